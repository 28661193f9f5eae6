#!/usr/bin/python3
"""Bakes real scenes with the built command line and prints one table of what it took and what came out.

  table.py [--scenes DIR] [--out DIR] [--lightbatch FILE] [--target-error 2%] [--no-npm] [--blender] [--every] [SCENE...]

DIR holds the .glb files; without SCENE words those of SCENES that it has are baked (tests/data/scenes has two of them), with
--every all that it has.
Columns: wall and CPU seconds, peak memory of the largest process, certified error with its 95 % interval and the target
that it is held to, texels, steps at chart borders, points shown bright that no light reaches, draw calls and triangles of a mean view before and after, errors of the Khronos validator in
the input and in scene.glb with the codes (of warnings too) that are new, and whether three.js and Blender load scene.glb (where they do
not, what they say of the input). npm packages (gltf-validator, three) go into a folder beside the results. Exit code 0:
every scene was baked, the validator finds nothing new and every loader that takes the input takes the output.
"""
import argparse
import json
import os
import pathlib
import re
import shutil
import struct
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
PACKAGES = ["gltf-validator", "three", "playwright-core"]


def run(words, **options):
    return subprocess.run([str(w) for w in words], capture_output=True, text=True, stdin=subprocess.DEVNULL, **options)


def bake(client, scene, out, options):
    """Exit code, wall seconds, CPU seconds, peak bytes of the largest process below."""
    with open(f"{out}.log", "w") as log:
        start = time.monotonic()
        process = subprocess.Popen([str(client), "bake", str(scene), "-o", str(out), "--no-cache", *options],
                                   stdout=log, stderr=log, stdin=subprocess.DEVNULL)
        _, status, used = os.wait4(process.pid, 0)
        return (os.waitstatus_to_exitcode(status), time.monotonic() - start, used.ru_utime + used.ru_stime,
                used.ru_maxrss * 1024)


def without_requirement(glb, extension):
    """The file with an extension used, but no longer required."""
    size = struct.unpack_from("<I", glb, 12)[0]
    document = json.loads(glb[20:20 + size])
    document["extensionsRequired"].remove(extension)
    if not document["extensionsRequired"]:
        del document["extensionsRequired"]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = glb[20 + size:]
    return struct.pack("<5I", 0x46546C67, 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest


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

    def validator(self, scene, result):
        """What to print, and whether the result has an error that the scene had not."""
        if not self.node:
            return "-", False
        before, after = (self.script("validate.mjs", path) for path in (scene, result))
        if "error" in after:
            return after["error"], True
        new = {code: count - before.get("codes", {}).get(code, 0) for code, count in after["codes"].items()}
        new = {code: count for code, count in new.items() if count > 0}
        text = f"{before.get('errors', 'refused')} -> {after['errors']}"
        return text + "".join(f", new {code} x {count}" for code, count in new.items()), bool(new)

    def three(self, path):
        return self.script("load_three.mjs", path) if self.node else None

    def imported(self, path):
        """Blender refuses a file for an extension that it does not know; then the rest of it is tried without."""
        if not self.blender:
            return None
        answer = self.blender_says(path)
        unknown = re.search(r"Extension (\w+) is not available", answer.get("error", ""))
        if unknown is None:
            return answer
        copy = self.folder.parent / "without.glb"
        copy.write_bytes(without_requirement(path.read_bytes(), unknown[1]))
        return {**self.blender_says(copy), "without": unknown[1]}

    def blender_says(self, path):
        # Blender takes the first Python of PATH for its home; only Debian's has what its importer wants.
        done = run([self.blender, "-b", "--factory-startup", "--python", HERE / "load_blender.py", "--", path],
                   env={**os.environ, "PATH": "/usr/bin:/bin"})
        for line in done.stdout.splitlines():
            if line.startswith("blender: "):
                return json.loads(line[len("blender: "):])
        return {"error": "no answer"}

    @staticmethod
    def loads(load, scene, result):
        """What to print, and whether the result is refused although the scene is taken."""
        answer = load(result)
        if answer is None:
            return "-", False
        if "error" not in answer:
            without = f" (but for {answer['without']})" if "without" in answer else ""
            return f"yes, {answer['meshes']} meshes{without}", False
        of_input = load(scene).get("error")
        return f"no: {answer['error']} (input: {'taken' if of_input is None else of_input})", of_input is None


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
    row["error"] = "nothing to light"
    if report.get("lightmaps", {}).get("texels"):
        row["error"] = (f"{value(report, 'accuracy/certified', '{:.2%}')} ({value(report, 'accuracy/low', '{:.2%}')} to "
                        f"{value(report, 'accuracy/high', '{:.2%}')}) of {value(report, 'accuracy/target', '{:.2%}')}")
    row["texels"] = value(report, "lightmaps/texels", "{:,}")
    for seam in report.get("borders", {}).get("seams", []):
        row[f"{seam['surface']} seams"] = (f"{seam['rms']:.2%} (p95 {seam['p95']:.2%}) on {seam['metres']:.0f} m"
                                           if seam["points"] else "none")
    row["leaks"] = (f"{value(report, 'borders/leaks/area_share', '{:.3%}')} of the surface "
                    f"({value(report, 'borders/leaks/leaks')} of {value(report, 'borders/leaks/points')} points)")
    row["batches"] = value(report, "batches/count", "{:,}")
    row["draws"] = f"{value(report, 'batches/before/draws', '{:.1f}')} -> {value(report, 'batches/after/draws', '{:.1f}')}"
    row["seen triangles"] = (f"{value(report, 'batches/before/triangles', '{:,.0f}')} -> "
                             f"{value(report, 'batches/after/triangles', '{:,.0f}')}")
    result = out / "scene.glb"
    row["validator"], row["worse"] = checks.validator(scene, result)
    for name, load in (("three.js", checks.three), ("Blender", checks.imported)):
        row[name], worse = checks.loads(load, scene, result)
        row["worse"] |= worse
    return row


def print_table(rows):
    columns = []
    for row in rows:
        columns += [c for c in row if c not in columns and c != "worse"]
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
    parser.add_argument("--every", action="store_true", help="every .glb of DIR")
    parser.add_argument("--blender", action="store_true", help="try Blender's importer as well")
    parser.add_argument("names", nargs="*", metavar="SCENE")
    words = parser.parse_args()
    words.out.mkdir(parents=True, exist_ok=True)
    checks = Checks(words.out, not words.no_npm, words.blender)
    rows = []
    every = sorted(path.stem for path in words.scenes.glob("*.glb")) if words.every else None
    for name in words.names or every or SCENES:
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
    return 0 if rows and not any(row["exit"] not in (0, 4) or row["worse"] for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
