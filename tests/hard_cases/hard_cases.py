#!/usr/bin/python3
"""The hard cases, the whole way: a scene made in code goes through the command line, and what comes out is compared with
a number. Prints one row for each: what it must give, what was measured.

  hard_cases.py --client LIGHTBATCH --data DIR [--only WORD]     DIR holds analytic.json and its scenes
"""
import argparse
import functools
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

import numpy as np

from made_scene import MadeScene, box, quad

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "peers"))
import points  # noqa: E402

WORDS = None
UP = (0, 1, 0)


class Run:
    """One run of the command on a scene."""

    def __init__(self, scene, *options, command="bake"):
        self.folder = tempfile.TemporaryDirectory()
        here = pathlib.Path(self.folder.name)
        if isinstance(scene, MadeScene):
            scene.write(here / "scene.gltf")
            scene = here / "scene.gltf"
        words = [WORDS.client, command, str(scene), "-o", str(here / "out"), *map(str, options)]
        done = subprocess.run(words, capture_output=True, text=True, timeout=600)
        self.code, self.errors = done.returncode, done.stderr
        self.report = {}
        if (here / "out" / "report.json").exists():
            self.report = json.load(open(here / "out" / "report.json"))
        self.files = {p.name: p.read_bytes() for p in here.glob("out/*") if p.suffix in (".exr", ".glb")}

    @functools.cached_property
    def bake(self):
        return points.Bake(pathlib.Path(self.folder.name) / "out")

    def at(self, point, normal):
        value = self.bake.irradiance(point, normal)
        return math.nan if value is None else float(value.mean())

    def texels(self):
        return np.concatenate([page.reshape(-1, 3) for page in self.bake.pages])


def worst(pairs):
    """Largest relative deviation of (measured, exact); not finite: as bad as can be."""
    values = [abs(got / exact - 1) for got, exact in pairs]
    return max(v if math.isfinite(v) else math.inf for v in values)


def inside(low, high, count, seed=1):
    """Points of the six walls of a box with the normals inwards, off the edges."""
    rng, found = random.Random(seed), []
    for k in range(count):
        axis, side = k % 3, k // 3 % 2
        p = [low[i] + (high[i] - low[i]) * rng.uniform(0.03, 0.97) for i in range(3)]
        n = [0, 0, 0]
        p[axis], n[axis] = (high if side else low)[axis], -1 if side else 1
        found.append((p, n))
    return found


def degenerate_triangles():
    scene = MadeScene()
    wall = scene.material(0.5, 10)
    rng = random.Random(7)
    point = lambda: tuple(rng.uniform(0.2, 0.8) for _ in range(3))
    dirt = []
    for _ in range(50):
        a, b = point(), point()
        dirt += [(a, a, a), (a, b, b), (a, tuple((x + y) / 2 for x, y in zip(a, b)), a)]
    slivers = [((0.2, 0, z), (0.2, 0, z + 5e-7), (0.7, 0, z)) for z in (0.2, 0.4, 0.6)]
    room = box((0, 0, 0), (1, 1, 1))
    scene.mesh(room + room[:4] + dirt + slivers, wall)
    run = Run(scene, "--target-error", "1%")
    exact = math.pi * 10 / (1 - 0.5)
    off = worst((run.at(*p), exact) for p in inside((0, 0, 0), (1, 1, 1), 60))
    finite = np.isfinite(run.texels()).all()
    dropped = run.report["scene"]["dropped"].get("triangles without area", 0)
    yield "zero-area, collinear, duplicate, sliver triangles in a furnace", "1 %", f"{100 * off:.3f} %", finite and off <= 0.01
    yield "... the 150 without area are dropped and counted", "150", str(dropped), dropped == 150


def vertex_not_finite():
    scene = MadeScene()
    scene.mesh(box((0, 0, 0), (1, 1, 1)) + [((0, 0, 0), (math.nan, 0, 0), (0, 1, 0))], scene.material(0.5, 10))
    run = Run(scene)
    named = "accessor" in run.errors and "0" in run.errors
    yield "a vertex that is not a number", "refused, accessor named", f"code {run.code}", run.code == 3 and named


def hostile_hierarchies():
    rng = random.Random(3)
    turned = []
    for _ in range(100_000):  # one centre, any size
        size, a = rng.uniform(0.01, 1), rng.uniform(0, math.tau)
        u, v = (size * math.cos(a), size * math.sin(a), 0), (0, size * math.sin(a), size * math.cos(a))
        turned.append((u, tuple(-(x + y) for x, y in zip(u, v)), v))
    same = [((0, 0, 0), (1, 0, 0), (0, 1, 0))] * 100_000
    uneven = [((-1e4, 0, -1e4), (1e4, 0, 1e4), (1e4, 0, -1e4))]
    for _ in range(100_000):
        p = [rng.uniform(0, 1) for _ in range(3)]
        uneven.append((p, (p[0] + 1e-3, p[1], p[2]), (p[0], p[1] + 1e-3, p[2])))
    for name, triangles in (("100,000 triangles about one centre", turned), ("100,000 times one triangle", same),
                            ("one huge among 100,000 tiny", uneven)):
        scene = MadeScene()
        scene.mesh(triangles, scene.material(0.5))
        run = Run(scene, "--no-lightmaps")
        tree = run.report.get("hierarchy", {})
        depth, seconds = tree.get("depth", math.inf), tree.get("build_seconds", math.inf)
        yield f"{name}: depth", "96", f"{depth} ({seconds:.2f} s)", run.code == 0 and depth <= 96


def room(transform=None):
    """A room of 4 x 3 x 5 metres with a lamp and a block."""
    scene = MadeScene()
    scene.mesh(box((0, 0, 0), (4, 3, 5)), scene.material(0.6))
    scene.mesh(box((1, 0, 2), (2, 1.2, 3.5), inwards=False), scene.material(0.3))
    scene.mesh(quad((1.5, 2.999, 1.5), (2.5, 2.999, 1.5), (2.5, 2.999, 2.5), (1.5, 2.999, 2.5)), scene.material(0, 100))
    if transform:
        scene.root["matrix"] = transform
    return scene


def transformed():
    where = inside((0, 0, 0), (4, 3, 5), 48, seed=5)
    where = [(p, n) for p, n in where if not (p[1] == 0 and 0.9 < p[0] < 2.1 and 1.9 < p[2] < 3.6)]
    where = [(p, n) for p, n in where if not (p[1] == 3 and 1.4 < p[0] < 2.6 and 1.4 < p[2] < 2.6)]
    plain = Run(room(), "--target-error", "0.7%", "--texels-per-metre", 15)
    for name, scale, move in (("moved by 1e6 m", (1, 1, 1), 1e6), ("scaled by 1e-3", (1e-3,) * 3, 0),
                              ("scaled by 1e4", (1e4,) * 3, 0), ("mirrored", (-1, 1, 1), 0)):
        matrix = [scale[0], 0, 0, 0, 0, scale[1], 0, 0, 0, 0, scale[2], 0, move, 0, -move, 1]
        run = Run(room(matrix), "--target-error", "0.7%", "--texels-per-metre", 15 / abs(scale[0]))
        squares, mean = 0, 0
        for p, n in where:
            q = [p[0] * scale[0] + move, p[1] * scale[1], p[2] * scale[2] - move]
            reference = plain.at(p, n)
            squares += (run.at(q, [n[0] * math.copysign(1, scale[0]), n[1], n[2]]) - reference) ** 2 / len(where)
            mean += reference / len(where)
        off = math.sqrt(squares) / mean
        # Both are off by up to 0.7 %.
        yield f"a room {name}: same light", "1 %", f"{100 * off:.3f} %", off <= 0.01


def zero_scale():
    scene = room()
    scene.mesh(box((0, 0, 0), (1, 1, 1)), 0, scale=[0, 1, 1])
    scene.mesh(box((0, 0, 0), (1, 1, 1)), 0, scale=[0, 0, 0])
    run = Run(scene, "--target-error", "10%", "--texels-per-metre", 10)
    dropped = run.report["scene"]["dropped"]
    nodes, flat = dropped.get("nodes of zero scale", 0), dropped.get("triangles without area", 0)
    yield ("node of zero scale dropped, a flattened one's 8 triangles too", "1 and 8", f"{nodes} and {flat}",
           run.code in (0, 4) and (nodes, flat) == (1, 8))


def wall_without_thickness():
    scene = MadeScene()
    wall = scene.material(0.8, double_sided=True)
    scene.mesh(box((0, 0, 0), (4, 3, 3)), wall)
    scene.mesh(quad((2, 0, 0), (2, 0, 3), (2, 3, 3), (2, 3, 0)), wall)
    scene.light("point", 100, translation=[1, 2, 1.5])
    run = Run(scene, "--target-error", "2%", "--texels-per-metre", 20)
    lit = [run.at((x, 0, z), UP) for x in (0.5, 1, 1.5) for z in (0.5, 1.5, 2.5)]
    # Two texels from the wall on: nearer, a bilinear look-up spans the foot of the wall.
    dark = [run.at((2 + d, 0, z), UP) for d in (0.1, 0.3, 1, 1.9) for z in (0.2, 1.5, 2.8)]
    dark += [run.at((4, y, z), (-1, 0, 0)) for y in (0.1, 1.5, 2.9) for z in (0.2, 1.5)]
    share = max(dark) / np.mean(lit)
    yield "dark room behind a wall of no thickness, at its foot too", "1e-4", f"{share:.1e}", share <= 1e-4


def coincident_faces():
    scene = MadeScene()
    floor = scene.material(0.0)
    down = quad((-2, 0, -2), (2, 0, -2), (2, 0, 2), (-2, 0, 2))
    up = [t[::-1] for t in down]
    scene.mesh(up + up + down, floor)
    scene.light("point", 100, translation=[0, 2, 0])
    run = Run(scene, "--target-error", "1%", "--texels-per-metre", 40)
    pairs = []
    for i in range(60):
        x, z = 1.9 * math.sin(2.4 * i) * i / 60, 1.9 * math.cos(2.4 * i) * i / 60
        d2 = x * x + z * z + 4
        pairs.append((run.at((x, 0, z), UP), 100 * 2 / d2 ** 1.5))
    off = worst(pairs)
    yield "coplanar duplicates, front and back: no acne", "1 %", f"{100 * off:.3f} %", off <= 0.01
    below = max(run.at((x, 0, 0.3), (0, -1, 0)) for x in (-1, 0, 1))
    yield "... and no leak below", "0 lux", f"{below:.2g} lux", below == 0


def sun_beside_candle():
    scene = MadeScene()
    black = scene.material(0.0)
    scene.mesh(quad((-5, 0, -5), (-5, 0, 5), (5, 0, 5), (5, 0, -5)), black)
    scene.mesh(box((10, 0, -1), (12, 2, 1)) + box((9.99, -0.01, -1.01), (12.01, 2.01, 1.01), inwards=False), black)
    scene.light("directional", 1e5, rotation=[-math.sin(math.pi / 6), 0, 0, math.cos(math.pi / 6)])  # 30 degrees up
    scene.light("point", 1, translation=[11, 1, 0])
    run = Run(scene, "--target-error", "1%", "--texels-per-metre", 20)
    elevation = math.sin(math.radians(60))
    sun = worst((run.at((x, 0, z), UP), 1e5 * elevation) for x in (-4, 0, 3) for z in (-3, 0, 4))
    pairs = []
    for i in range(5):
        for k in range(5):
            x, z = 10.2 + 0.4 * i, -0.8 + 0.4 * k
            pairs.append((run.at((x, 0, z), UP), 1 / ((x - 11) ** 2 + 1 + z * z) ** 1.5))
    candle = worst(pairs)
    yield "sun of 1e5 lux", "1 %", f"{100 * sun:.3f} %", sun <= 0.01
    yield "... beside a candle of 1 cd in a closed box", "1 %", f"{100 * candle:.3f} %", candle <= 0.01


def lamp_in_a_housing():
    half, wall = 0.04, 0.0005
    for ground in (10, 100_000):
        scene = MadeScene()
        grey, unlit = scene.material(0.5), scene.material(0.5, extensions={"KHR_materials_unlit": {}})
        scene.mesh(box((-2, 0, -2), (2, 3, 2)), grey)
        scene.mesh(box((-half, 1.5 - half, -half), (half, 1.5 + half, half)), grey)
        scene.mesh(box((-half - wall, 1.5 - half - wall, -half - wall), (half + wall, 1.5 + half + wall, half + wall),
                       inwards=False), grey)
        scene.mesh(quad((-ground, -1, ground), (ground, -1, ground), (ground, -1, -ground), (-ground, -1, -ground)), unlit)
        scene.light("point", 100, translation=[0, 1.5, 0])
        run = Run(scene, "--target-error", "10%", "--texels-per-metre", 20)
        leak = max(run.at((x, 0, z), UP) for x in (-1.5, 0, 1.1) for z in (-1.2, 0, 1.7))
        yield (f"room around a lamp of 100 cd in a closed housing of 8 cm, ground of {2 * ground} m", "0 lux",
               f"{leak:.2g} lux", leak == 0)


def under_lamps(side):
    scene = MadeScene()
    scene.mesh(quad((0, 0, 0), (0, 0, 4), (4, 0, 4), (4, 0, 0)), scene.material(0.0))
    lamps, cell = [], 4 / side
    for i in range(side):
        for k in range(side):
            x, z = (i + 0.25) * cell, (k + 0.25) * cell
            lamps += quad((x, 1, z), (x + cell / 2, 1, z), (x + cell / 2, 1, z + cell / 2), (x, 1, z + cell / 2))
    scene.mesh(lamps, scene.material(0.0, 400))
    run = Run(scene, "--target-error", "2%", "--texels-per-metre", 25)
    effects = {e["name"]: e for e in run.report["plan"]["effects"]}
    work = sum(effects["emitters"]["counters"].values()) / run.report["lightmaps"]["texels"]
    return run, work


def ten_thousand_lamps():
    _, few = under_lamps(10)
    run, many = under_lamps(100)
    # A quarter of the ceiling shines with 400 nits: seen from the floor, 100 nits all over.
    def exact(x, z):
        total = 0.0
        for a, b in ((x, z), (4 - x, z), (x, 4 - z), (4 - x, 4 - z)):
            p, q = math.hypot(a, 1), math.hypot(b, 1)
            total += (a / p * math.atan(b / p) + b / q * math.atan(a / q)) / 2
        return 100 * total
    where = [(0.5 + 0.6 * i, 0.4 + 0.65 * k) for i in range(6) for k in range(6)]
    off = math.sqrt(np.mean([(run.at((x, 0, z), UP) / exact(x, z) - 1) ** 2 for x, z in where]))
    yield "20,000 lamp triangles", "2 %", f"{100 * off:.3f} %", off <= 0.02
    yield "... work per texel against 200 of them (x100 lamps)", "10", f"{many / few:.2f}", many / few <= 10


def grazing_light():
    scene = MadeScene()
    rings, sectors = 8, 12
    at = lambda i, k: (math.sin(math.pi * i / rings) * math.cos(math.tau * k / sectors), math.cos(math.pi * i / rings),
                       math.sin(math.pi * i / rings) * math.sin(math.tau * k / sectors))
    ball = []
    for i in range(rings):
        for k in range(sectors):
            a, b, c, d = at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)
            ball += [(a, b, c)] * (i > 0) + [(a, c, d)] * (i < rings - 1)
    scene.mesh(ball, scene.material(0.0))
    scene.light("directional", 1000)  # along -z
    run = Run(scene, "--target-error", "1%", "--texels-per-metre", 100)
    deviations = []
    for t in ball:
        p = np.array(t, float)
        normal = np.cross(p[1] - p[0], p[2] - p[0])
        normal /= np.linalg.norm(normal)
        got = run.at(p.mean(0), normal)
        deviations.append(abs(got / 1000 - max(0.0, normal[2])))
    off = max(v if math.isfinite(v) else math.inf for v in deviations)
    yield "coarse ball in grazing sunlight: no terminator bands", "1 % of the sun", f"{100 * off:.3f} %", off <= 0.01


def energy():
    opened = MadeScene()
    opened.mesh(box((0, 0, 0), (4, 3, 5))[:10], opened.material(0.6))
    opened.mesh(box((1, 0, 2), (2, 1.2, 3.5), inwards=False), opened.material(0.3))
    opened.mesh(quad((1.5, 2.9, 1.5), (2.5, 2.9, 1.5), (2.5, 2.9, 2.5), (1.5, 2.9, 2.5)), opened.material(0, 100))
    for name, scene in (("closed", room()), ("open", opened)):
        for solver in ("stored-ray", "linked"):
            run = Run(scene, "--target-error", "10%", "--texels-per-metre", 5, "--solver", solver)
            e = run.report["radiosity"]["energy"]
            off = max(abs(a + x - m) / m for a, x, m in zip(e["absorbed"], e["escaped"], e["emitted"]))
            yield f"energy of the {name} room, {solver}", "0.1 %", f"{100 * off:.2g} %", off <= 1e-3


def threads():
    one = Run(room(), "--target-error", "5%", "--texels-per-metre", 10, "--threads", 1)
    two = Run(room(), "--target-error", "5%", "--texels-per-metre", 10, "--threads", 2)
    same = one.files == two.files and len(one.files) > 1
    yield "same bytes on 1 and 2 threads", "equal", "equal" if same else "different", same


def closed_forms():
    data = pathlib.Path(WORDS.data)
    cases = {c["name"]: c for c in json.load(open(data / "analytic.json"))["cases"]}
    for name in ("lamp_one_millimetre_above_floor", "lamp_touching_floor", "furnace_0.99", "furnace_0.999"):
        case = cases[name]
        run = Run(data / case["file"], "--target-error", "1%")
        off = worst((float(g), e) for r in case["receivers"] for g, e in
                    zip(run.bake.irradiance(r["position"], r["normal"]), r["irradiance_lux"]) if e > 0)
        limit = case["tolerance_relative"]
        yield name.replace("_", " "), f"{100 * limit:g} %", f"{100 * off:.3f} %", off <= limit


CASES = [degenerate_triangles, vertex_not_finite, hostile_hierarchies, transformed, zero_scale, closed_forms,
         wall_without_thickness, coincident_faces, sun_beside_candle, lamp_in_a_housing, ten_thousand_lamps, grazing_light, energy, threads]


def main():
    global WORDS
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--client", required=True)
    parser.add_argument("--data", required=True)
    parser.add_argument("--only", default="")
    WORDS = parser.parse_args()
    missed = 0
    print(f"{'':4}{'case':66}{'must be at most':26}measured")
    for case in CASES:
        if WORDS.only not in case.__name__:
            continue
        for name, limit, measured, good in case():
            missed += not good
            print(f"{'ok' if good else 'BAD':4}{name:66}{limit:26}{measured}", flush=True)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
