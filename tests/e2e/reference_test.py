#!/usr/bin/python3
"""Every scene with closed-form light, the whole way: file -> lightbatch bake -> scene.glb and lightmap_K.exr, read at the
receivers as a renderer would. Each receiver within the tolerance that its case states, at --target-error 1%.

  reference_test.py --client LIGHTBATCH --data DIR [--only CASE]     DIR holds analytic.json and the scenes
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "peers"))
import points  # noqa: E402


def bake(client, scene, sky, folder):
    """Exit code 4 (certified error above the target) is not an error here: the receivers judge."""
    words = [client, "bake", str(scene), "-o", folder, "--target-error", "1%"]
    if sky > 0:
        words += ["--sky", str(sky)]
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode not in (0, 4):
        sys.exit(f"{scene.name}: exit code {done.returncode}\n{done.stderr}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--client", required=True)
    parser.add_argument("--data", required=True)
    parser.add_argument("--only")
    words = parser.parse_args()
    data = pathlib.Path(words.data)
    cases = json.load(open(data / "analytic.json"))["cases"]
    missed = []
    for case in cases:
        if words.only and case["name"] != words.only:
            continue
        with tempfile.TemporaryDirectory() as folder:
            bake(words.client, data / case["file"], case["environment_nits"], folder)
            if points.judge_analytic(points.Bake(folder), case):
                missed.append(case["name"])
    print(f"{len(cases) - len(missed)} of {len(cases)} scenes within their tolerance" +
          (": missed " + ", ".join(missed) if missed else ""))
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
