#!/usr/bin/python3
"""How honest prices are: every scene that has light, quoted and baked at each target, and at time budgets.

  prices.py --scenes DIR [--build DIR] [--targets 5%,2%,1%] [--budgets 10,30] [--sky NITS] [--coarser F] [--longest S]
            [--out DIR] [WORD...]

Scenes: the .glb files of the folder (WORD: part of a name), and a generated office. --sky lights those that have no light of their
own; without, these are left out. --coarser: lightmaps of a density so many times
lower than chosen from the scene. Rows whose quote is above --longest seconds are left out and counted. Prints a row a bake as a Markdown
table: seconds quoted and taken, the certified error with its interval, what was foretold; then the shares that a price is judged by:
certified at or below the target, below half of it, time within 30 % of the quote, budgets kept within 10 %.
prices.json in --out holds the same. Run it with nothing else on the machine: a quote is seconds.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
OFFICE_TRIANGLES = 20_000


def run(words, *command):
    """(exit code, report, seconds)"""
    began = time.monotonic()
    done = subprocess.run([str(words.build / "client/cli/lightbatch"), *map(str, command), "--json", "-q"], capture_output=True, text=True,
                          stdin=subprocess.DEVNULL)
    seconds = time.monotonic() - began
    if done.returncode not in (0, 4):
        return done.returncode, done.stderr.strip().splitlines()[-1:], seconds
    if "-o" in command:
        return done.returncode, json.loads((command[command.index("-o") + 1] / "report.json").read_text()), seconds
    return done.returncode, json.loads(done.stdout)["report"], seconds


def lit(report, sky):
    effects = {e["name"]: e["on"] for e in report["plan"]["effects"]}
    own = any(effects[name] for name in ("point_lights", "spot_lights", "directional_lights", "emitters"))
    return own or (sky > 0 and effects["sky"])


def prices_of(words, scene, folder):
    options = ["--sky", words.sky] if words.sky > 0 else []
    code, report, _ = run(words, "plan", scene, *options)
    if code != 0:
        print(f"{scene.name}: {report}", file=sys.stderr)
        return
    if not lit(report, words.sky):
        print(f"{scene.name}: no light", file=sys.stderr)
        return
    if words.coarser > 1:
        code, report, _ = run(words, "quote", scene, "--no-cache", *options)
        density = report["lightmaps"]["texels_per_metre_given"] if code == 0 else 0
        options += ["--texels-per-metre", f"{density / words.coarser:.4g}"] if density > 0 else []
    code, report, _ = run(words, "quote", scene, "--no-cache", *options)
    if code != 0:
        print(f"{scene.name}: {report}", file=sys.stderr)
        return
    if report["lightmaps"]["texels"] == 0:
        print(f"{scene.name}: no surface to light", file=sys.stderr)
        return
    quoted = {round(price["error"], 6): price for price in report["quote"]}
    for target in words.targets:
        price = quoted[min(quoted, key=lambda error: abs(error - target))]
        row = {"scene": scene.stem, "target": target, "quoted": price["seconds"]}
        if price["seconds"] > words.longest:
            yield {**row, "left_out": True}
            continue
        code, baked, seconds = run(words, "bake", scene, "-o", folder / "out", "--no-cache", "--target-error", f"{100 * target}%", *options)
        if code not in (0, 4):
            sys.exit(f"{scene}: {baked}")
        yield {**row, **measured(baked), "seconds": seconds}
    for budget in words.budgets:
        code, baked, seconds = run(words, "bake", scene, "-o", folder / "out", "--no-cache", "--time-budget", f"{budget}s", *options)
        if code not in (0, 4):
            sys.exit(f"{scene}: {baked}")
        yield {"scene": scene.stem, "budget": budget, **measured(baked), "seconds": seconds}


def measured(report):
    accuracy = report["accuracy"]
    return {"texels": report["lightmaps"]["texels"], "certified": accuracy["certified"], "low": accuracy["low"],
            "high": accuracy["high"], "foretold": report.get("expected", {}).get("error")}


def line(row):
    if row.get("left_out"):
        return f"| {row['scene']} | | {100 * row['target']:g} % | {row['quoted']:.0f} s | left out | | |"
    asked = f"{100 * row['target']:g} %" if "target" in row else f"{row['budget']:g} s"
    quoted = f"{row['quoted']:.1f} s" if "quoted" in row else ""
    foretold = "" if row["foretold"] is None else f"{100 * row['foretold']:.1f} %"
    return (f"| {row['scene']} | {row['texels']:,} | {asked} | {quoted} | {row['seconds']:.1f} s | {100 * row['certified']:.2f} % "
            f"({100 * row['low']:.1f} to {100 * row['high']:.1f}) | {foretold} |")


def share(rows, holds):
    kept = sum(1 for row in rows if holds(row))
    return f"{kept} of {len(rows)}" + (f" ({100 * kept / len(rows):.0f} %)" if rows else "")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=pathlib.Path, required=True)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--targets", default="5%,2%,1%")
    parser.add_argument("--budgets", default="")
    parser.add_argument("--sky", type=float, default=0)
    parser.add_argument("--coarser", type=float, default=1)
    parser.add_argument("--longest", type=float, default=300)
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("words", nargs="*")
    words = parser.parse_args()
    words.targets = [float(t.strip("% ")) / 100 for t in words.targets.split(",") if t]
    words.budgets = [float(b) for b in words.budgets.split(",") if b]
    rows = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        scenes = [scene for scene in sorted(words.scenes.glob("*.glb")) if not words.words or any(w in scene.name for w in words.words)]
        if not words.words or any(w in "office.glb" for w in words.words):
            subprocess.run([str(words.build / "client/cli/lightbatch"), "scene", "office", "--triangles", str(OFFICE_TRIANGLES), "-o",
                            str(folder / "office.glb")], check=True, capture_output=True)
            scenes.append(folder / "office.glb")
        print("| scene | texels | asked | quoted | took | certified (95 % interval) | foretold |\n| --- | --- | --- | --- | --- | --- | --- |")
        for scene in scenes:
            for row in prices_of(words, scene, folder):
                rows.append(row)
                print(line(row), flush=True)
    baked = [row for row in rows if "target" in row and "seconds" in row]
    print(f"\ncertified at or below the target: {share(baked, lambda r: r['certified'] <= r['target'])}")
    print(f"certified below half of it: {share(baked, lambda r: r['certified'] < r['target'] / 2)}")
    print(f"time within 30 % of the quote: {share(baked, lambda r: abs(r['seconds'] / r['quoted'] - 1) <= 0.3)}")
    budgets = [row for row in rows if "budget" in row]
    if budgets:
        print(f"budgets kept within 10 %: {share(budgets, lambda r: r['seconds'] <= 1.1 * r['budget'])}")
    print(f"left out as too long: {sum(1 for row in rows if row.get('left_out'))}")
    if words.out:
        words.out.mkdir(parents=True, exist_ok=True)
        (words.out / "prices.json").write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
