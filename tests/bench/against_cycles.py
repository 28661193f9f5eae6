#!/usr/bin/python3
"""CPU seconds of lightbatch's bake beside those of Blender's Cycles for the same error, scene by scene, as a Markdown table.

  against_cycles.py --scenes DIR [--build DIR] [--out DIR] [--targets 5%,2%,1%] [--budget S] [--paths N] [SCENE...]

DIR holds the .glb files; the office is generated. For each scene lightbatch bakes at the targets, and Cycles bakes into the very
same lightmap coordinates and resolution at sample counts that rise fourfold until --budget CPU seconds are spent. Both are
compared, texel by texel, with the path tracer of core/accuracy (build/tests/bench/texel_reference): relRMSE over texels drawn
uniformly by area among those that one triangle covers wholly (Cycles samples no other); the reference's own noise is taken off by the
product of the residuals against its two halves, and an error is never stated below the standard error of that estimate.

Columns: target, lightbatch's measured error and CPU seconds (pilot, solve and gather: stages of report.json), then the seconds that
Cycles takes to the same error: read off its measured curve, or, beyond its longest bake, continued by the power law of error against
samples through its last three bakes, at least N^-1/2 (marked ~; the measured exponent is given), and the ratio. Import, charts and files are left out on both
sides; the certificate is, too. Emitters are meshes in both. Beside the table: cycles.csv, cycles.json. Needs Debian's blender and python3-numpy.
"""
import argparse
import csv
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(HERE.parent / "peers"))
import exr_file  # noqa: E402

# Sky in nits, texels a metre.
SCENES = {
    "cornell_measured": (0, 100),
    "office": (0, 3),
    "classroom": (0, 10),
    "vianney_house_garden": (1000, 0.3),
}
OFFICE_TRIANGLES = 10000
BAKE_STAGES = ("pilot", "radiosity", "gather")
RESAMPLES = 400
LEAST_EXPONENT = 0.5  # of error against samples, in the long run, for any sampler of finite variance


def run(words, **options):
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True, stdin=subprocess.DEVNULL, **options)
    if done.returncode not in (0, 4):  # 4: baked, but the certificate missed the target; the error is measured here
        sys.exit(f"{' '.join(str(w) for w in words)}\nexit code {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


class Reference:
    """Texels with two independent estimates of their irradiance."""

    def __init__(self, path):
        rows = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
        self.page, self.x, self.y = rows[:, :3].astype(int).T
        self.halves = rows[:, 3:6], rows[:, 6:9]

    def error(self, pages):
        """relRMSE of the pages and the standard error of its square, both against the mean; NaN texels are left out."""
        value = np.array([pages[p][y, x] for p, x, y in zip(self.page, self.x, self.y)], float)
        seen = np.isfinite(value).all(1)
        value, first, second = value[seen], self.halves[0][seen], self.halves[1][seen]
        mean = (first.mean() + second.mean()) / 2
        squares = ((value - first) * (value - second)).mean(1) / mean ** 2
        random = np.random.default_rng(1)
        spread = np.std([random.choice(squares, len(squares)).mean() for _ in range(RESAMPLES)])
        bias = (value - (first + second) / 2).mean() / mean
        return {"error": math.sqrt(max(squares.mean(), spread)), "spread": float(spread), "bias": float(bias), "compared": int(seen.sum())}


def lightbatch(words, scene, sky, density, target, out):
    options = ["--sky", sky] if sky else []
    run([words.build / "client/cli/lightbatch", "bake", scene, "-o", out, "--no-cache", "--no-batches", "--target-error", target,
         "--texels-per-metre", density, *options])
    report = json.loads((out / "report.json").read_text())
    stages = {s["name"]: s for s in report["stages"]}
    pages = [exr_file.read_rgb(out / f"{p['name']}.exr")[0] for p in report["lightmaps"]["pages"]]
    return pages, {"target": target, "cpu_seconds": sum(stages[s]["cpu_seconds"] for s in BAKE_STAGES),
                   "whole_cpu_seconds": report["total"]["cpu_seconds"], "peak_bytes": report["total"]["peak_bytes"],
                   "certified": report["accuracy"]["certified"], "texels": report["lightmaps"]["texels"],
                   "triangles": report["scene"]["triangles"]}


def cycles(words, baked, scene, sky, out):
    # Blender takes the first Python of PATH for its home; only Debian's has numpy for it.
    text = run([words.blender, "-b", "-noaudio", "--factory-startup", "--python-exit-code", "1", "--python", HERE / "cycles_bake.py", "--",
                baked, scene, out, "--sky", sky, "--budget", words.budget], env={**os.environ, "PATH": "/usr/bin:/bin"})
    bakes = [json.loads(line[len("cycles: "):]) for line in text.splitlines() if line.startswith("cycles: ")]
    if not bakes:
        sys.exit(f"Blender baked nothing\n{text[-2000:]}")
    return bakes


def seconds_at(bakes, error):
    """CPU seconds to the error on the curve of the bakes; exponent p of error ~ samples^-p over the last ones; whether the error lies
    beyond the longest (or before the shortest) bake. Time is linear in samples."""
    samples = np.array([b["samples"] for b in bakes], float)
    errors = np.log([b["error"] for b in bakes])
    exponent = -np.polyfit(np.log(samples[-3:]), errors[-3:], 1)[0]
    at, continued = math.log(error), not errors[-1] <= math.log(error) <= errors[0]
    law = max(exponent, LEAST_EXPONENT)
    if at < errors[-1]:
        needed = samples[-1] * math.exp((errors[-1] - at) / law)
    elif at > errors[0]:
        needed = samples[0] / math.exp((at - errors[0]) / law)
    else:
        needed = math.exp(np.interp(-at, -errors, np.log(samples)))
    a_sample, start = np.polyfit(samples, [b["cpu_seconds"] for b in bakes], 1)
    return max(start, 0.0) + a_sample * needed, exponent, continued


def compare(words, name):
    sky, density = SCENES[name]
    folder = words.out / name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    scene = words.scenes / f"{name}.glb"
    if name == "office":
        scene = folder / "office.glb"
        run([words.build / "client/cli/lightbatch", "scene", "office", "--triangles", OFFICE_TRIANGLES, "-o", scene])
    bakes = [lightbatch(words, scene, sky, density, t, folder / t.strip("%")) for t in words.targets.split(",")]
    reference = folder / "reference.csv"
    run([words.build / "tests/bench/texel_reference", scene, reference, "--sky", sky, "--texels-per-metre", density,
         "--count", words.count, "--paths", words.paths])
    truth = Reference(reference)
    for pages, bake in bakes:
        bake.update(truth.error(pages))
    first = folder / words.targets.split(",")[0].strip("%")
    curve = cycles(words, first / "scene.glb", scene, sky, folder / "cycles")
    for bake in curve:
        with np.load(bake["file"]) as pages:
            bake.update(truth.error([pages[f"lightmap_{k}"] for k in range(len(pages.files))]))
    for _, bake in bakes:
        bake["cycles_cpu_seconds"], bake["exponent"], bake["continued"] = seconds_at(curve, bake["error"])
        bake["ratio"] = bake["cycles_cpu_seconds"] / bake["cpu_seconds"]
    return {"scene": name, "texels_per_metre": density, "sky_nits": sky, "lightbatch": [b for _, b in bakes], "cycles": curve}


def print_head():
    print("| scene | texels | asked | error | lightbatch CPU s | peak MiB | Cycles CPU s to that error | ratio | bakes of Cycles (peak) |")
    print("|" + " --- |" * 9, flush=True)


def print_rows(result):
    curve = "; ".join(f"{c['cpu_seconds']:.3g} s {c['error']:.1%}" for c in result["cycles"])
    peak = result["cycles"][-1]["peak_bytes"] / 2**20
    for k, bake in enumerate(result["lightbatch"]):
        print(f"| {result['scene'] if k == 0 else ''} | {bake['texels']:,} | {bake['target']} | {bake['error']:.2%} | {bake['cpu_seconds']:.2f} | "
              f"{bake['peak_bytes'] / 2**20:.0f} | {'~' if bake['continued'] else ''}{bake['cycles_cpu_seconds']:.3g} "
              f"(N^-{bake['exponent']:.2f}) | {bake['ratio']:.0f} | {f'{curve} ({peak:.0f} MiB)' if k == 0 else ''} |", flush=True)


def write_files(words, results):
    (words.out / "cycles.json").write_text(json.dumps(results, indent=1) + "\n")
    with open(words.out / "cycles.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["scene", "baker", "asked", "samples", "cpu_seconds", "error", "bias", "peak_bytes", "cycles_cpu_seconds", "ratio"])
        for result in results:
            for b in result["lightbatch"]:
                table.writerow([result["scene"], "lightbatch", b["target"], "", b["cpu_seconds"], b["error"], b["bias"], b["peak_bytes"],
                                b["cycles_cpu_seconds"], b["ratio"]])
            for c in result["cycles"]:
                table.writerow([result["scene"], "Cycles", "", c["samples"], c["cpu_seconds"], c["error"], c["bias"], c["peak_bytes"], "", ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=pathlib.Path, required=True)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release", help="built with LIGHTBATCH_BENCHMARKS=ON")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build/cycles")
    parser.add_argument("--targets", default="5%,2%,1%")
    parser.add_argument("--budget", type=float, default=100, help="CPU seconds of Cycles, each scene")
    parser.add_argument("--count", type=int, default=1000, help="texels of the reference")
    parser.add_argument("--paths", type=int, default=8192, help="paths of each half of a texel's reference")
    parser.add_argument("--blender", default="blender")
    parser.add_argument("names", nargs="*", metavar="SCENE")
    words = parser.parse_args()
    if shutil.which(words.blender) is None:
        sys.exit("Blender is not installed (apt-get install blender); without it there is no Cycles to compare with")
    results = []
    for name in words.names or SCENES:
        if name not in SCENES:
            sys.exit(f"no such scene: {name}; there are {', '.join(SCENES)}")
        results.append(compare(words, name))
        if len(results) == 1:
            print_head()
        print_rows(results[-1])
        write_files(words, results)


if __name__ == "__main__":
    main()
