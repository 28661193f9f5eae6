#!/usr/bin/python3
"""How the price of a bake grows with the scene and with the lamps in it, as two Markdown tables.

  growth.py [--build DIR] [--out DIR] [--triangles 10000,40000,160000,640000] [--lamps 10,100,1000,10000,100000] [--density D]
            [--target-error 5%] [--timeout S]

Scene: generated offices, more rooms the more triangles, at one density of texels. Lamps: one hall of 24 x 24 x 3 m with furniture
under a grid of lamps a metre below the ceiling, of the same total power, once as glowing panels, once as point lights. CPU seconds are those of the whole
command, "light" those of pilot, solve and gather; rays are all that were cast for light; a stored ray is a link of the solution;
bytes are the peak of the process (and `base`, what a scene of a thousand triangles takes). Exponents: of CPU seconds against
triangles, or against lamps, from one row to the next (1: linear).
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests/hard_cases"))
from made_scene import MadeScene, box, quad  # noqa: E402

LIGHT_STAGES = ("pilot", "radiosity", "gather")
HALL, HEIGHT = 24.0, 3.0
LUMENS_PER_M2 = 300.0  # of all lamps together, over the floor


def bake(words, scene, out):
    """The report, or None when it took too long."""
    command = [words.build / "client/cli/lightbatch", "bake", scene, "-o", out, "--no-cache", "--no-batches", "--target-error",
               words.target_error, "--texels-per-metre", words.density]
    try:
        done = subprocess.run([str(w) for w in command], capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=words.timeout)
    except subprocess.TimeoutExpired:
        return None
    if done.returncode not in (0, 4):
        sys.exit(f"{scene}: exit code {done.returncode}\n{done.stderr[-2000:]}")
    return json.loads((out / "report.json").read_text())


def row_of(report):
    counters = {}
    for effect in report["plan"]["effects"]:
        for name, value in effect.get("counters", {}).items():
            counters[name] = max(value, counters.get(name, 0))  # some effects show the same counter
    texels = report["lightmaps"]["texels"]
    links = sum(report["radiosity"]["links"].values())
    return {"triangles": report["scene"]["triangles"], "texels": texels, "cpu": report["total"]["cpu_seconds"],
            "light": sum(s["cpu_seconds"] for s in report["stages"] if s["name"] in LIGHT_STAGES),
            "rays": (counters.get("hemisphere rays", 0) + counters.get("shadow rays", 0)) / max(1, texels),
            "links": links / max(1, report["radiosity"]["elements"]), "bytes": report["total"]["peak_bytes"],
            "error": report["accuracy"]["certified"]}


def exponent(before, row, size, price):
    return "-" if before is None else f"{math.log(row[price] / before[price]) / math.log(row[size] / before[size]):.2f}"


def offices(words):
    words.out.mkdir(parents=True, exist_ok=True)
    base = None
    print(f"Offices, {words.density:g} texels a metre, {words.target_error}\n")
    print("| triangles | texels | CPU s | light | exponent of CPU | rays a texel | stored rays an element | bytes a triangle | less base | certified |")
    print("|" + " --- |" * 10)
    before = None
    for triangles in [1000] + words.triangles:
        scene = words.out / f"office_{triangles}.glb"
        subprocess.run([str(words.build / "client/cli/lightbatch"), "scene", "office", "--triangles", str(triangles), "-o", str(scene)],
                       check=True, capture_output=True)
        report = bake(words, scene, words.out / f"office_{triangles}")
        if report is None:
            print(f"| {triangles:,} | more than {words.timeout:g} s |")
            return
        row = row_of(report)
        if base is None:
            base = row["bytes"]
            continue
        print(f"| {row['triangles']:,} | {row['texels']:,} | {row['cpu']:.1f} | {row['light']:.1f} | {exponent(before, row, 'triangles', 'cpu')} | "
              f"{row['rays']:.0f} | {row['links']:.1f} | {row['bytes'] / row['triangles']:,.0f} | "
              f"{(row['bytes'] - base) / row['triangles']:,.0f} | {row['error']:.1%} |", flush=True)
        before = row


def hall(lamps, points, path):
    scene = MadeScene()
    grey = scene.material(0.6)
    scene.mesh(box((0, 0, 0), (HALL, HEIGHT, HALL)), grey)
    for k in range(64):
        x, z = 3 * (k % 8) + 0.8, 3 * (k // 8) + 0.9
        scene.mesh(box((x, 0.01, z), (x + 1.4, 0.75, z + 0.7), inwards=False), grey)
    side = math.ceil(math.sqrt(lamps))
    cell, edge = HALL / side, min(0.3, 0.5 * HALL / side)
    lumens = LUMENS_PER_M2 * HALL * HALL / lamps
    panels = []
    for k in range(lamps):
        x, z, y = (k % side + 0.5) * cell, (k // side + 0.5) * cell, HEIGHT - 1
        if points:
            scene.light("point", lumens / (4 * math.pi), translation=[x, y, z])
        else:
            a, b = edge / 2, -edge / 2
            panels += quad((x + b, y, z + b), (x + a, y, z + b), (x + a, y, z + a), (x + b, y, z + a))
    if panels:
        scene.mesh(panels, scene.material(0.0, lumens / (math.pi * edge * edge)))
    scene.write(path)


def lamp_table(words):
    print(f"\nLamps, {words.density:g} texels a metre, {words.target_error}\n")
    print("| lamps | kind | texels | CPU s | light | exponent of CPU | rays a texel | certified |")
    print("|" + " --- |" * 8)
    for points, kind in ((False, "panels"), (True, "points")):
        before = None
        for lamps in words.lamps:
            scene = words.out / f"{kind}_{lamps}.gltf"
            hall(lamps, points, scene)
            report = bake(words, scene, words.out / f"{kind}_{lamps}")
            if report is None:
                print(f"| {lamps:,} | {kind} | more than {words.timeout:g} s |", flush=True)
                break
            row = {"lamps": lamps, **row_of(report)}
            print(f"| {lamps:,} | {kind} | {row['texels']:,} | {row['cpu']:.1f} | {row['light']:.1f} | {exponent(before, row, 'lamps', 'cpu')} | "
                  f"{row['rays']:.0f} | {row['error']:.1%} |", flush=True)
            before = row


def numbers(text):
    return [int(n) for n in text.split(",") if n]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build/growth")
    parser.add_argument("--triangles", type=numbers, default=[10000, 40000, 160000, 640000])
    parser.add_argument("--lamps", type=numbers, default=[10, 100, 1000, 10000, 100000])
    parser.add_argument("--density", type=float, default=2, help="texels a metre")
    parser.add_argument("--target-error", default="5%")
    parser.add_argument("--timeout", type=float, default=600, help="seconds for one bake")
    words = parser.parse_args()
    if words.triangles:
        offices(words)
    if words.lamps:
        lamp_table(words)


if __name__ == "__main__":
    main()
