#!/usr/bin/python3
"""Compares a bake with known irradiance at points of its surfaces.

  points.py BAKE --reference REFERENCE.csv         CSV with x,y,z,nx,ny,nz,E_r,E_g,E_b (lux)
  points.py BAKE --analytic ANALYTIC.json CASE     the receivers of one case, judged by its tolerance

BAKE is the folder of a bake. Each point is found on the triangles of scene.glb (position and normal); the page
lightmap_K.exr that its material's MOZ_lightmap names is read there through TEXCOORD_1, bilinearly, as a renderer would.
Prints one line of figures: relRMSE, median, 95th percentile and worst error relative to the mean irradiance, and bias.
"""
import argparse
import csv
import json
import pathlib
import sys

import numpy as np

import exr_file
import gltf_file

REACH = 1e-3  # of the scene's diagonal: how far from a surface a point may lie


def bilinear(image, uv):
    height, width = image.shape[:2]
    x, y = np.clip(uv[0] * width - 0.5, 0, width - 1), np.clip(uv[1] * height - 0.5, 0, height - 1)
    x0, y0 = int(x), int(y)
    x1, y1, fx, fy = min(x0 + 1, width - 1), min(y0 + 1, height - 1), x - int(x), y - int(y)
    upper = image[y0, x0] * (1 - fx) + image[y0, x1] * fx
    lower = image[y1, x0] * (1 - fx) + image[y1, x1] * fx
    return upper * (1 - fy) + lower * fy


class Bake:
    def __init__(self, folder):
        folder = pathlib.Path(folder)
        self.lit = gltf_file.LitTriangles(gltf_file.Glb(folder / "scene.glb"))
        self.pages = [exr_file.read_rgb(folder / f"{name}.exr")[0] for name in self.lit.page_names]
        self.reach = REACH * np.linalg.norm(self.lit.upper.max(0) - self.lit.lower.min(0))

    def irradiance(self, point, normal):
        """Lux at a surface point; None where no lit surface lies."""
        found = self.lit.find(np.asarray(point, float), np.asarray(normal, float), self.reach)
        return None if found is None else bilinear(self.pages[self.lit.pages[found[0]]], found[1])


def read_points(path):
    with open(path, newline="") as file:
        rows = [[float(row[k]) for k in ("x", "y", "z", "nx", "ny", "nz", "E_r", "E_g", "E_b")]
                for row in csv.DictReader(file)]
    rows = np.array(rows)
    return rows[:, 0:3], rows[:, 3:6], rows[:, 6:9]


def compare(bake, points, normals, expected):
    got = [bake.irradiance(p, n) for p, n in zip(points, normals)]
    seen = np.array([g is not None for g in got]) & np.isfinite(expected).all(1)
    if not seen.any():
        sys.exit("no point lies on a surface with a lightmap")
    measured, truth = np.array([g for g, s in zip(got, seen) if s]), expected[seen]
    mean = truth.mean()
    error = measured - truth
    size = np.sqrt((error ** 2).mean(1)) / mean
    return {"points": int(seen.sum()), "off_surface": int((~seen).sum()), "mean_lux": float(mean),
            "relrmse": float(np.sqrt((error ** 2).mean()) / mean), "p50": float(np.median(size)),
            "p95": float(np.percentile(size, 95)), "worst": float(size.max()), "bias": float(error.mean() / mean)}


def dark_limit(bake, case):
    """What a receiver may show where the closed form is 0: a thousandth of the brightest receiver; with none lit, 1e-4 of
    the light of the lit part (the median of texels above a hundredth of the brightest)."""
    brightest = max(max(r["irradiance_lux"]) for r in case["receivers"])
    if brightest > 0:
        return 1e-3 * brightest
    texels = np.concatenate([page.max(-1).ravel() for page in bake.pages])
    return 1e-4 * float(np.median(texels[texels > 0.01 * texels.max()]))


def judge_analytic(bake, case):
    """Prints each receiver; the number of those outside the tolerance."""
    tolerance, dark, bad = case["tolerance_relative"], dark_limit(bake, case), 0
    for receiver in case["receivers"]:
        got, truth = bake.irradiance(receiver["position"], receiver["normal"]), np.array(receiver["irradiance_lux"])
        if got is None:
            good, shown = False, "not on a surface with a lightmap"
        else:
            allowed = np.where(truth > 0, tolerance * truth, dark)
            good, shown = bool((np.abs(got - truth) <= allowed).all()), " ".join(f"{v:.6g}" for v in got)
        bad += not good
        print(f"{'ok ' if good else 'BAD'} {receiver['position']}  expected {' '.join(f'{v:.6g}' for v in truth)}  got {shown}")
    print(f"{case['name']}: {len(case['receivers']) - bad} of {len(case['receivers'])} within {100 * tolerance:g} %, "
          f"dark below {dark:.3g} lux")
    return bad


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bake")
    parser.add_argument("--reference")
    parser.add_argument("--analytic", nargs=2, metavar=("JSON", "CASE"))
    words = parser.parse_args()
    bake = Bake(words.bake)
    if words.analytic:
        cases = {case["name"]: case for case in json.load(open(words.analytic[0]))["cases"]}
        return 1 if judge_analytic(bake, cases[words.analytic[1]]) else 0
    if not words.reference:
        parser.error("give --reference or --analytic")
    figures = compare(bake, *read_points(words.reference))
    print(" ".join(f"{k}={v:.6g}" if isinstance(v, float) else f"{k}={v}" for k, v in figures.items()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
