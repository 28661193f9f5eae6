#!/usr/bin/python3
"""Bakes real scenes with the built command line and prints one table of what it took and what came out.

  table.py [--scenes DIR] [--out DIR] [--lightbatch FILE] [--target-error 2%] [--no-npm] [--blender] [SCENE...]

DIR holds the .glb files; without SCENE words those of SCENES that it has are baked (tests/data/scenes has two of them).
Columns: wall and CPU seconds, peak memory of the largest process, certified error with its 95 % interval, texels, draw
calls and triangles of a mean view before and after, errors of the Khronos validator in the input and in scene.glb, and
whether three.js and Blender load scene.glb. npm packages (gltf-validator, three) go into a folder beside the results.
"""
import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
# Scenes and the sky they ask for (nits); those with lights of their own need none.
SCENES = {
    "cornell_measured": 0,
    "classroom": 0,
    "small_room.draco_webp": 1000,
    "littlest_tokyo.draco": 1000,
    "hotel_room.meshopt": 1000,
    "hotel_block_instanced": 1000,
    "vianney_house_garden": 1000,
    "folio_areas": 1000,
    "truck_town.webp": 1000,
    "fox.skinned": 1000,
    "hotel_block_1m.draco": 1000,
}
PACKAGES = ["gltf-validator", "three"]


def run(words, **options):
    return subprocess.run([str(w) for w in words], capture_output=True, text=True, stdin=subprocess.DEVNULL, **options)


def bake(client, scene, out, options):
    """Exit code, wall seconds, CPU seconds, peak bytes of the largest process below."""
    with open(out.with_suffix(".log"), "w") as log:
        start = time.monotonic()
        process = subprocess.Popen([str(client), "bake", str(scene), "-o", str(out), "--no-cache", *options],
                                   stdout=log, stderr=log, stdin=subprocess.DEVNULL)
        _, status, used = os.wait4(process.pid, 0)
        return (os.waitstatus_to_exitcode(status), time.monotonic() - start, used.ru_utime + used.ru_stime,
                used.ru_maxrss * 1024)


class Checks:
    """What others say of the files; None where the tool is not there."""

    def __init__(self, out, npm, blender):
        self.folder = out / "npm"
        self.node = npm and shutil.which("node") and shutil.which("npm") and self.install()
        self.blender = blender and shutil.which("blender")

    def install(self):
        self.folder.mkdir(parents=True, exist_ok=True)
        if not all((self.folder / "node_modules" / p).is_dir() for p in PACKAGES):
            done = run(["npm", "install", "--no-audit", "--no-fund", "--prefix", self.folder, *PACKAGES])
            if done.returncode != 0:
                print(f"npm packages are not to be had; validator and three.js left out\n{done.stderr}", file=sys.stderr)
                return False
        for script in ("validate.mjs", "load_three.mjs"):  # modules are found from the script's own folder
            shutil.copy(HERE / script, self.folder / script)
        return True

    def script(self, name, path):
        if not self.node:
            return None
        done = run(["node", self.folder / name, path])
        try:
            return json.loads(done.stdout.strip().splitlines()[-1])
        except (IndexError, json.JSONDecodeError):
            return {"error": (done.stderr.strip().splitlines() or ["no answer"])[-1]}

    def validator_errors(self, path):
        answer = self.script("validate.mjs", path)
        return None if answer is None else answer.get("errors", answer.get("error"))

    def three(self, path):
        answer = self.script("load_three.mjs", path)
        return None if answer is None else answer.get("error", f"yes, {answer.get('meshes')} meshes")

    def imported(self, path):
        if not self.blender:
            return None
        done = run([self.blender, "-b", "--factory-startup", "--python", HERE / "load_blender.py", "--", path])
        for line in done.stdout.splitlines():
            if line.startswith("blender: "):
                answer = json.loads(line[len("blender: "):])
                return answer.get("error", f"yes, {answer.get('meshes')} meshes")
        return "no answer"


def value(report, path, form="{}"):
    for key in path.split("/"):
        report = report.get(key) if isinstance(report, dict) else None
    return "-" if report is None else form.format(report)


def row_of(name, scene, out, taken, checks):
    code, wall, cpu, peak = taken
    row = {"scene": name, "exit": code, "wall s": f"{wall:.1f}", "cpu s": f"{cpu:.1f}", "peak MiB": f"{peak / 2**20:.0f}"}
    if code not in (0, 4):
        return row
    report = json.loads((out / "report.json").read_text())
    row["triangles"] = value(report, "scene/triangles", "{:,}")
    row["error"] = (f"{value(report, 'accuracy/certified', '{:.2%}')} ({value(report, 'accuracy/low', '{:.2%}')} to "
                    f"{value(report, 'accuracy/high', '{:.2%}')})")
    row["texels"] = value(report, "lightmaps/texels", "{:,}")
    row["draws"] = f"{value(report, 'batches/before/draws', '{:.1f}')} -> {value(report, 'batches/after/draws', '{:.1f}')}"
    row["seen triangles"] = (f"{value(report, 'batches/before/triangles', '{:,.0f}')} -> "
                             f"{value(report, 'batches/after/triangles', '{:,.0f}')}")
    result = out / "scene.glb"
    before, after = checks.validator_errors(scene), checks.validator_errors(result)
    row["validator"] = "-" if after is None else f"{before} -> {after}"
    row["three.js"] = checks.three(result) or "-"
    row["Blender"] = checks.imported(result) or "-"
    return row


def print_table(rows):
    columns = []
    for row in rows:
        columns += [c for c in row if c not in columns]
    print("| " + " | ".join(columns) + " |")
    print("|" + " --- |" * len(columns))
    for row in rows:
        print("| " + " | ".join(str(row.get(c, "-")) for c in columns) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=pathlib.Path, default=ROOT / "tests/data/scenes")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build/table")
    parser.add_argument("--lightbatch", type=pathlib.Path, default=ROOT / "build/release/client/cli/lightbatch")
    parser.add_argument("--target-error", default="2%")
    parser.add_argument("--option", action="append", default=[], help="a further option of bake, as --option=--seed=2")
    parser.add_argument("--no-npm", action="store_true")
    parser.add_argument("--blender", action="store_true", help="try Blender's importer as well")
    parser.add_argument("names", nargs="*", metavar="SCENE")
    words = parser.parse_args()
    words.out.mkdir(parents=True, exist_ok=True)
    checks = Checks(words.out, not words.no_npm, words.blender)
    rows = []
    for name in words.names or SCENES:
        scene = words.scenes / f"{name}.glb"
        if not scene.is_file():
            if words.names:
                sys.exit(f"no such scene: {scene}")
            continue
        out = words.out / name
        shutil.rmtree(out, ignore_errors=True)
        options = ["--target-error", words.target_error, *words.option]
        if SCENES.get(name, 1000):
            options += ["--sky", str(SCENES.get(name, 1000))]
        taken = bake(words.lightbatch, scene, out, options)
        rows.append(row_of(name, scene, out, taken, checks))
        print(f"{name}: exit code {taken[0]}, {taken[1]:.1f} s", file=sys.stderr)
    print_table(rows)
    return 0 if rows and all(row["exit"] in (0, 4) for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
