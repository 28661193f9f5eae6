#!/usr/bin/python3
"""Looks and speed of batches in a viewer: three.js in headless Chromium, the same poses before and after.

  frames.py [--scenes DIR] [--out DIR] [--lightbatch FILE] [--frames N] [--option=OPTION] [SCENE...]

Bakes each .glb of DIR (or the named ones) without lightmaps and prints a table: difference of the pictures (largest of the
poses' means, share of full scale), draws, triangles and milliseconds a frame, means over the poses inside: script alone, and
all CPU of the browser with its software rasteriser (medians of three turns of N frames or more; 0: pictures only). Exit code 0: every difference is
below 1 %; where the input has more than 500 draws, script takes at most a third of its time; nowhere does a frame take more
CPU than 1/0.95 of the input's. Needs npm (three, playwright-core) and Debian's chromium.
"""
import argparse
import json
import pathlib
import shutil
import sys

import table

LARGEST_DIFFERENCE, MANY_DRAWS, FASTER, SLOWEST = 0.01, 500, 3.0, 0.95


def frames(checks, scene, result, count):
    """The answers of frames.mjs for both files."""
    done = table.run(["node", table.HERE / "frames.mjs", checks.folder / "node_modules", scene, result, "--frames", count])
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    if len(rows) != 2 or any("error" in row for row in rows):
        raise RuntimeError(f"{scene}: {[row.get('error') for row in rows]} {done.stderr[-300:]}")
    return rows


def judge(before, after, draws):
    """What falls short, in words."""
    short = []
    if after["difference"] > LARGEST_DIFFERENCE:
        short.append("picture differs")
    if after["messages"] and not before["messages"]:
        short.append(after["messages"][0])
    if "inside" in before:
        script, cpu = (before["inside"][key] / after["inside"][key] for key in ("script", "cpu"))
        if draws > MANY_DRAWS and script < FASTER:
            short.append(f"script only {script:.2f}x faster")
        if cpu < SLOWEST:
            short.append(f"frames {cpu:.2f}x as fast")
    return ", ".join(short)


def row_of(scene, before, after, draws, short):
    cells = [scene, f"{after['difference']:.3%}", str(draws)]
    for key, shape in (("draws", ".1f"), ("triangles", ",.0f"), ("script", ".3f"), ("cpu", ".1f")):
        if "inside" in before:
            a, b = before["inside"][key], after["inside"][key]
            cells.append(f"{a:{shape}} -> {b:{shape}}" + (f" ({a / b:.2f}x)" if key in ("script", "cpu") else ""))
    return "| " + " | ".join(cells + [short or "ok"]) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=pathlib.Path, default=table.ROOT / "tests/data/scenes")
    parser.add_argument("--out", type=pathlib.Path, default=table.ROOT / "build/frames")
    parser.add_argument("--lightbatch", type=pathlib.Path, default=table.ROOT / "build/release/client/cli/lightbatch")
    parser.add_argument("--frames", type=int, default=2)
    parser.add_argument("--option", action="append", default=[], help="of bake, as --option=--profile=webgl")
    parser.add_argument("names", nargs="*", metavar="SCENE")
    words = parser.parse_args()
    words.out.mkdir(parents=True, exist_ok=True)
    checks = table.Checks(words.out, True, False)
    if not checks.node:
        sys.exit("node and npm are needed")
    print("| scene | pictures | draws of all | draws | triangles | script ms | CPU ms | |\n|" + " --- |" * 8)
    failed = 0
    for name in words.names or sorted(path.stem for path in words.scenes.glob("*.glb")):
        scene, out = words.scenes / f"{name}.glb", words.out / name
        shutil.rmtree(out, ignore_errors=True)
        code = table.bake(words.lightbatch, scene, out, ["--no-lightmaps", *words.option])[0]
        if code != 0:
            sys.exit(f"{name}: exit code {code}; see {out}.log")
        draws = json.loads((out / "report.json").read_text())["batches"]["before"]["all_draws"]
        before, after = frames(checks, scene, out / "scene.glb", words.frames)
        short = judge(before, after, draws)
        failed += bool(short)
        print(row_of(name, before, after, draws, short), flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
