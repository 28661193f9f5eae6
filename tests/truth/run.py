#!/usr/bin/python3
"""Scenes made in code whose light is known in closed form, each baked and read at points as a renderer would.

  run.py --client LIGHTBATCH [--err 0.5%] [--keep DIR] [--fast] [WORD...]     WORD: part of a scene's name

Prints for each scene the worst and the mean deviation over its points, what is tolerated, what the bake certified of itself,
and CPU seconds; the exit code is 1 when a scene is off by more. --keep DIR: scenes, bakes and points are left there, and every
point is printed that is off. --fast: the subset that stands for the others. Where the closed form is 0, a thousandth of the
scene's brightest point is tolerated, and a ten-thousandth everywhere.
"""
import argparse
import importlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import case as scenes
import hdr_file
import points

SUITES = ("cases_lights", "cases_emitters", "cases_occluders", "cases_bounces")
# Of each class one or two that are quickly baked.
FAST = {"point/0.001m_off", "point/tiny", "spot/0.001rad", "textured/mask", "range/1.5m", "spot/wide", "sun/grazing", "emitter/parallel_2m", "emitter/two_sided",
        "emitter/placed_mirrored", "emitter/instanced_quantised", "sky/wall_low", "sky/map_zenith", "sky/map_sun_narrow", "shadow/strip",
        "sheet/glass_1", "small/cube_point", "small/cube_emitter", "furnace/l_shape_0.7", "equilibrium/court"}
DARK = 1e-3
FAINT = 1e-4
GRID = 24  # points of a texel, each way


def all_cases():
    for suite in SUITES:
        yield from importlib.import_module(suite).cases()


def bake(client, case, error, folder):
    scene = folder / "scene.gltf"
    case.scene.write(scene)
    words = [client, "bake", str(scene), "-o", str(folder / "out"), "--target-error", error, "--no-batches"]
    if case.density:
        words += ["--texels-per-metre", repr(case.density / case.scale())]
    if isinstance(case.sky, np.ndarray):
        hdr_file.write(folder / "sky.hdr", case.sky)
        words += ["--sky", str(folder / "sky.hdr")]
    elif case.sky:
        words += ["--sky", str(case.sky)]
    began = os.times()
    done = subprocess.run(words, capture_output=True, text=True)
    # A certified error above the target is not an error here: the points judge.
    if done.returncode not in (0, 4):
        raise RuntimeError(f"{case.name}: exit code {done.returncode}\n{done.stderr}")
    ended = os.times()
    seconds = ended.children_user + ended.children_system - began.children_user - began.children_system
    return seconds, json.load(open(folder / "out" / "report.json"))


class TexelForm:
    """What a perfect lightmap shows at a point: means of the form over the four texels about it, bilinear."""

    def __init__(self, baked, case):
        self.baked, self.case = baked, case

    def __call__(self, world, world_normal, normal):
        lit = self.baked.lit
        triangle, uv = lit.find(world, world_normal, self.baked.reach)
        height, width = self.baked.pages[lit.pages[triangle]].shape[:2]
        edges = np.array([lit.uvs[triangle][k] - lit.uvs[triangle][0] for k in (1, 2)]).T * [[width], [height]]
        sides = np.array([lit.corners[triangle][k] - lit.corners[triangle][0] for k in (1, 2)]).T
        to_surface = sides @ np.linalg.inv(edges)

        def at(x, y):
            where = np.array([x, y]) - lit.uvs[triangle][0] * [width, height]
            return self.case.from_world(lit.corners[triangle][0] + to_surface @ where)

        x, y = uv[0] * width - 0.5, uv[1] * height - 0.5
        total = np.zeros(3)
        for i in (0, 1):
            for j in (0, 1):
                weight = abs(1 - i - (x - np.floor(x))) * abs(1 - j - (y - np.floor(y)))
                if weight > 1e-9:
                    total += weight * self.texel(at, np.floor(x) + i, np.floor(y) + j, normal)
        return total

    def texel(self, at, x, y, normal):
        form = self.case.light
        exact = getattr(form, "mean", None)
        value = exact([at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)], normal) if exact else None
        if value is not None:
            return value
        steps = (np.arange(GRID) + 0.5) / GRID
        return np.mean([form(at(x + a, y + b), normal) for a in steps for b in steps], 0)


def judge(case, folder, shown):
    """(worst, mean) deviation over the receivers, relative to each point's own light; of dark ones to what is tolerated."""
    baked = points.Bake(folder / "out")
    texels = TexelForm(baked, case) if case.over_texels else None
    rows = []
    for point, normal in case.receivers:
        world, world_normal = case.to_world(point, normal)
        got = baked.irradiance(world, world_normal)
        exact = texels(world, world_normal, normal) if texels and got is not None else case.light(point, normal)
        rows.append((point, exact, got))
    brightest = max(np.max(exact) for _, exact, _ in rows)
    deviations = []
    for point, exact, got in rows:
        if got is None or not np.isfinite(got).all():
            deviations.append(np.inf)
        else:
            allowed = np.where(exact > 0, np.maximum(exact, FAINT / case.tolerance * brightest), DARK / case.tolerance * brightest)
            deviations.append(float(np.max(np.abs(got - exact) / allowed)))
        if shown and deviations[-1] > 0.7 * case.tolerance:
            read = "no lightmap there" if got is None else np.array2string(got, precision=5)
            print(f"    {np.array2string(point, precision=4)}: exact {np.array2string(exact, precision=5)}, got {read}, "
                  f"{100 * deviations[-1]:.2f} %")
    return max(deviations), float(np.mean(deviations))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--client", required=True)
    parser.add_argument("--err", default="0.5%")
    parser.add_argument("--keep", type=pathlib.Path)
    parser.add_argument("--fast", action="store_true")
    parser.add_argument("words", nargs="*")
    words = parser.parse_args()
    print(f"{'scene':34} {'worst':>9} {'mean':>9} {'may be':>7} {'certified':>10} {'s':>6}")
    missed, count, seconds = [], 0, 0.0
    for case in all_cases():
        if (words.words and not any(w in case.name for w in words.words)) or (words.fast and case.name not in FAST):
            continue
        with tempfile.TemporaryDirectory() as made:
            folder = words.keep / case.name.replace("/", "_") if words.keep else pathlib.Path(made)
            folder.mkdir(parents=True, exist_ok=True)
            took, report = bake(words.client, case, words.err, folder)
            worst, mean = judge(case, folder, words.keep is not None)
        certified = report["accuracy"].get("certified")
        count, seconds = count + 1, seconds + took
        good = worst <= case.tolerance
        if not good:
            missed.append(case.name)
        print(f"{case.name:34} {100 * worst:7.3f} % {100 * mean:7.3f} % {100 * case.tolerance:5.2g} % "
              f"{'-' if certified is None else f'{100 * certified:.3f} %':>10} {took:6.1f}{'' if good else '  MISSED'}", flush=True)
    print(f"{count - len(missed)} of {count} scenes within their tolerance, {seconds:.0f} CPU seconds" +
          (": missed " + ", ".join(missed) if missed else ""))
    return 1 if missed or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
