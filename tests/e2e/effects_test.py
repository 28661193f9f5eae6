#!/usr/bin/python3
"""Effects of the plan, the whole way: on where the scene calls for them, with evidence and counters; off: counters 0,
no stage, no file.

  effects_test.py --client LIGHTBATCH --shared DIR     DIR holds scenes/
"""
import json
import math
import os
import pathlib
import sys
import unittest

import numpy as np

import programs
from programs import WithFolder, lightbatch

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "hard_cases"))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "peers"))
import exr_file  # noqa: E402
import gltf_file  # noqa: E402
import points  # noqa: E402
from made_scene import MadeScene, box, quad  # noqa: E402


class Bake:
    """One run of the command on a scene, and what it says of itself."""

    def __init__(self, test, scene, *options):
        test.runs = getattr(test, "runs", 0) + 1
        self.folder = test.path(f"out{test.runs}")
        if isinstance(scene, MadeScene):
            path = test.path(f"scene{test.runs}.gltf")
            scene.write(path)
            scene = path
        done = lightbatch("bake", scene, "-o", self.folder, *options)
        test.assertIn(done.returncode, (0, 4), done.stderr)
        self.report = json.load(open(os.path.join(self.folder, "report.json")))
        self.effects = {e["name"]: e for e in self.report["plan"]["effects"]}
        self.stages = [s["name"] for s in self.report["stages"]]
        self.files = {name: open(os.path.join(self.folder, name), "rb").read() for name in os.listdir(self.folder)}

    def extras(self):
        document = gltf_file.Glb(os.path.join(self.folder, "scene.glb")).json
        return document["scenes"][document.get("scene", 0)]["extras"]["lightbatch"]


class Probes:
    """A reader of probes.json, written after the README alone."""

    def __init__(self, bake):
        data = json.loads(bake.files[bake.extras()["probes"]["file"]])
        self.volumes = data["volumes"]
        self.position = np.array(data["probes"]["position"])
        self.valid = np.array(data["probes"]["valid"])
        self.irradiance = np.array(data["probes"]["irradiance"]).reshape(-1, 9, 3)
        for volume in self.volumes:
            volume["places"] = {tuple(c[:4]): c[4:] for c in volume["cells"]}

    @staticmethod
    def basis(n):
        x, y, z = n
        return np.array([0.28209479, 0.48860251 * y, 0.48860251 * z, 0.48860251 * x, 1.09254843 * x * y, 1.09254843 * y * z,
                         0.31539157 * (3 * z * z - 1), 1.09254843 * x * z, 0.54627422 * (x * x - y * y)])

    def at(self, point, normal):
        """Interpolated irradiance, r g b; None where no mesh comes."""
        for volume in self.volumes:
            s = (np.array(point) - volume["origin"]) / volume["step"]
            size = 1
            while size <= volume["largest"]:
                corner = (np.floor(s / size) * size).astype(int)
                probes = volume["places"].get((*corner, size))
                if probes:
                    t, total, weights = (s - corner) / size, np.zeros(3), 0
                    for k, p in enumerate(probes):
                        w = math.prod(t[a] if k >> a & 1 else 1 - t[a] for a in range(3)) * self.valid[p]
                        total, weights = total + w * (self.basis(normal) @ self.irradiance[p]), weights + w
                    return total / weights if weights > 0 else None
                size *= 2
        return None


class EffectsTest(WithFolder):
    def scene(self, name):
        path = os.path.join(programs.OPTIONS.shared, "scenes", name)
        if not os.path.exists(path):
            self.skipTest(f"{name} is not here")
        return path


class ProbesTest(EffectsTest):
    def assertAbsent(self, bake):
        effect = bake.effects["probes"]
        self.assertFalse(effect["on"])
        self.assertEqual(set(effect["counters"].values()), {0})
        self.assertNotIn("probes", bake.stages)
        self.assertNotIn("probes", bake.report)
        self.assertNotIn("probes.json", bake.files)
        self.assertNotIn("probes", bake.extras())

    def assertPresent(self, bake):
        effect = bake.effects["probes"]
        self.assertTrue(effect["on"])
        self.assertTrue(effect["evidence"])
        self.assertGreater(effect["counters"]["probes"], 0)
        self.assertGreater(effect["counters"]["probe rays"], 0)
        self.assertIn("probes", bake.stages)
        self.assertIn(b"Light probes", bake.files["report.html"])

    def test_a_skinned_animal_under_the_sky(self):
        for name, node in (("fox.skinned.glb", 1), ("morph_stress.glb", 0)):
            bake = Bake(self, self.scene(name), "--sky", 100)
            self.assertPresent(bake)
            probes = Probes(bake)
            self.assertEqual([v["nodes"] for v in probes.volumes], [[node]])
            self.assertTrue(probes.valid.all())
            for c in probes.irradiance:
                self.assertTrue(np.allclose(c[0], math.pi * 100 * math.sqrt(4 * math.pi), rtol=1e-3), c[0])
                self.assertLess(np.abs(c[1:]).max(), 1e-3 * c[0].max())
            self.assertAbsent(Bake(self, self.scene(name), "--sky", 100, "--effects", "-probes"))
            self.assertAbsent(Bake(self, self.scene(name)))  # no light

    def test_it_moves_through_a_room(self):
        """A lamp in a black room: what reaches a probe is Lambert's formula, order 2 of it in the coefficients."""
        scene = MadeScene()
        scene.mesh(box((0, 0, 0), (6, 3, 4)), scene.material(0.0))
        scene.light("point", 100, translation=[3, 2.9, 2])
        scene.mesh(box((0.5, 0.5, 1.8), (0.9, 0.9, 2.2), inwards=False), scene.material(0.5), name="cart")
        self.assertAbsent(Bake(self, scene, "--target-error", "10%"))
        scene.animate(len(scene.nodes) - 1, [0, 4], [(0, 0, 0), (4.5, 0, 0)])
        bake = Bake(self, scene, "--target-error", "5%")
        self.assertPresent(bake)
        self.assertIn("cart", bake.effects["probes"]["evidence"][0])
        probes = Probes(bake)
        inside = (probes.position > [0, 0, 0]).all(1) & (probes.position < [6, 3, 4]).all(1)
        self.assertTrue(inside.any())
        for i in np.flatnonzero(inside):
            to = np.array([3, 2.9, 2]) - probes.position[i]
            expected = 100 / (to @ to) * Probes.basis(to / np.linalg.norm(to)) * (
                math.pi, *[2 * math.pi / 3] * 3, *[math.pi / 4] * 5)
            self.assertTrue(np.allclose(probes.irradiance[i, :, 1], expected, atol=2e-3 * abs(expected).max()))
        for x in np.linspace(0.5, 5.4, 15):  # the whole way has light
            self.assertIsNotNone(probes.at((x, 0.7, 2), (0, 1, 0)), x)
        one = Bake(self, scene, "--target-error", "5%", "--threads", 1)
        self.assertEqual(bake.files["probes.json"], one.files["probes.json"])
        off = Bake(self, scene, "--target-error", "5%", "--effects", "-probes")
        self.assertAbsent(off)
        self.assertEqual(bake.files["lightmap_0.exr"], off.files["lightmap_0.exr"])


class DirectionalTest(EffectsTest):
    def assertAbsent(self, bake):
        effect = bake.effects["directional_lightmaps"]
        self.assertFalse(effect["on"])
        self.assertEqual(set(effect["counters"].values()), {0})
        self.assertNotIn("directional", bake.stages)
        self.assertFalse([name for name in bake.files if name.endswith("_dir.exr")])
        self.assertNotIn("directional", bake.extras())

    def pages(self, bake):
        """{name of a page: (direction, irradiance, alpha)}"""
        effect = bake.effects["directional_lightmaps"]
        self.assertTrue(effect["on"])
        self.assertTrue(effect["evidence"])
        self.assertGreater(effect["counters"]["directional texels"], 0)
        self.assertIn("directional", bake.stages)
        read = lambda name: exr_file.read_rgb(os.path.join(bake.folder, name))
        return {e["page"]: (*read(e["file"]), read(e["page"] + ".exr")[0]) for e in bake.extras()["directional"]}

    def floor(self, **more):
        scene = MadeScene()
        bumps = scene.texture([[(128, 128, 255, 255)]])
        scene.mesh(quad((-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)), scene.material(0.0, normalTexture=bumps, **more),
                   uv=lambda p: (p[0], p[2]))
        scene.mesh(quad((3, 0, 2), (7, 0, 2), (7, 0, -2), (3, 0, -2)), scene.material(0.0))
        return scene

    def test_a_sun_comes_from_one_direction(self):
        scene = self.floor()
        scene.light("directional", 1000, rotation=[-math.sin(math.pi / 8), 0, 0, math.cos(math.pi / 8)])  # 45 degrees down
        bake = Bake(self, scene)
        for direction, alpha, irradiance in self.pages(bake).values():
            asked = alpha > 0
            self.assertTrue(asked.any())
            self.assertTrue((irradiance.max(2)[~asked] > 0).any())  # the plain floor has light and no direction
            self.assertTrue(np.allclose(direction[asked], [0, math.sqrt(0.5), math.sqrt(0.5)], atol=2e-3))
        off = Bake(self, scene, "--effects", "-directional_lightmaps")
        self.assertAbsent(off)
        self.assertEqual(off.files["lightmap_0.exr"], bake.files["lightmap_0.exr"])
        self.assertAbsent(Bake(self, scene, "--carrier", "portable"))
        one = Bake(self, scene, "--threads", 1)
        self.assertEqual(one.files["lightmap_0_dir.exr"], bake.files["lightmap_0_dir.exr"])

    def test_not_without_light_nor_on_unlit_materials(self):
        self.assertAbsent(Bake(self, self.floor()))
        self.assertAbsent(Bake(self, self.floor(extensions={"KHR_materials_unlit": {}}), "--sky", 100))

    def test_a_real_scene(self):
        scene = self.scene("depth_of_field.glb")
        words = ["--target-error", "10%", "--texels-per-metre", 30]
        bake = Bake(self, scene, *words)
        for direction, alpha, irradiance in self.pages(bake).values():
            length = np.linalg.norm(direction[(alpha > 0) & (irradiance.max(2) > 0)], axis=1)
            self.assertTrue((length <= 1.001).all())
            self.assertGreater(np.median(length), 0.3)
        off = Bake(self, scene, *words, "--effects", "-directional_lightmaps")
        self.assertAbsent(off)
        pages = [name for name in off.files if name.startswith("lightmap_")]
        self.assertTrue(pages)
        for name in pages:
            self.assertEqual(off.files[name], bake.files[name])


def sphere(levels):
    """An octahedron subdivided, on the unit sphere, fronts inwards."""
    axes = [(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)]
    triangles = []
    for k in range(4):
        a, b = axes[k], axes[(k + 1) % 4]
        triangles += [(a, (0, 0, 1), b), (b, (0, 0, -1), a)]
    middle = lambda p, q: tuple(v / math.hypot(*(x + y for x, y in zip(p, q))) for v in (x + y for x, y in zip(p, q)))
    for _ in range(levels):
        cut = []
        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            cut += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = cut
    return triangles


def two_tone(dark, bright, width=64):
    """sRGB texels, the left half dark."""
    return [[(dark,) * 3 + (255,) if x < width // 2 else (bright,) * 3 + (255,) for x in range(width)]]


def linear(byte):
    v = byte / 255
    return v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4


class Table(EffectsTest):
    """Every effect of the plan: where the scene calls for it, a closed form; where it is off, nothing was done."""

    def analytic(self, name):
        data = pathlib.Path(__file__).resolve().parent.parent / "data" / "reference"
        case = next(c for c in json.load(open(data / "analytic.json"))["cases"] if c["name"] == name)
        def judge(bake):
            self.assertFalse(points.judge_analytic(points.Bake(bake.folder), case), name)
        return data / case["file"], ["--sky", case["environment_nits"]] if case["environment_nits"] > 0 else [], judge

    def at(self, where, normal, expected, tolerance=0.01):
        def judge(bake):
            got = points.Bake(bake.folder).irradiance(where, normal)
            self.assertIsNotNone(got)
            self.assertLess(abs(got.mean() / expected - 1), tolerance, (got, expected))
        return judge

    def textured_reflectance(self):
        """In a sphere every point sees every other alike: E = pi L / (1 - mean reflectance)."""
        scene = MadeScene()
        tones = scene.texture(two_tone(60, 230))
        scene.mesh(sphere(3), scene.material(1.0, 10, pbrMetallicRoughness={"baseColorTexture": tones}),
                   uv=lambda p: ((p[0] - 0.03) / 2 + 0.5, 0.5))
        dark_share = (1 + 0.03) / 2
        mean = linear(60) * dark_share + linear(230) * (1 - dark_share)
        exact = math.pi * 10 / (1 - mean)
        return scene, [], self.at((0, math.sqrt(0.5), math.sqrt(0.5)), (0, -math.sqrt(0.5), -math.sqrt(0.5)), exact, 0.015)

    def textured_emission(self):
        """A lamp of 2 x 1 m, 1 m over the floor, half of it dark: Lambert's formula for the other half, from its corner."""
        scene = MadeScene()
        tones = scene.texture(two_tone(0, 255, 512))
        scene.mesh(quad((-9, 0, 9), (9, 0, 9), (9, 0, -9), (-9, 0, -9)), scene.material(0.0))
        scene.mesh(quad((-1, 1, -1), (1, 1, -1), (1, 1, 0), (-1, 1, 0)),
                   scene.material(0.0, 100, emissiveTexture=tones), uv=lambda p: ((p[0] + 1) / 2, 0.5))
        corner = 1 / (2 * math.pi) * 2 * (1 / math.sqrt(2)) * math.atan(1 / math.sqrt(2))
        return scene, [], self.at((0, 0, 0), (0, 1, 0), math.pi * 100 * corner, 0.015)

    def alpha_blend(self):
        """A black sheet that covers a quarter, under a sun straight above."""
        scene = MadeScene()
        sheet = scene.material(0.0, double_sided=True, alphaMode="BLEND", pbrMetallicRoughness={"baseColorFactor": [0, 0, 0, 0.25]})
        scene.mesh(quad((-9, 0, 9), (9, 0, 9), (9, 0, -9), (-9, 0, -9)), scene.material(0.0))
        scene.mesh(quad((-3, 1, 3), (3, 1, 3), (3, 1, -3), (-3, 1, -3)), sheet)
        scene.light("directional", 1000, rotation=[-math.sqrt(0.5), 0, 0, math.sqrt(0.5)])
        return scene, [], self.at((0.2, 0, 0.1), (0, 1, 0), 750)

    def two_sided(self):
        """A furnace whose faces are turned outwards: only their backs see each other."""
        scene = MadeScene()
        scene.mesh(box((0, 0, 0), (1, 1, 1), inwards=False), scene.material(0.5, 10, double_sided=True))
        return scene, [], self.at((0.4, 0, 0.6), (0, -1, 0), math.pi * 10 / (1 - 0.5))

    def diffuse_transmission(self):
        """A black sheet that lets light through diffusely, 16 m wide, 2 m over a floor, under a sun straight above: the
        sheet shines with what comes through, and Lambert's formula says how much the floor sees of it."""
        scene = MadeScene()
        through = {"diffuseTransmissionFactor": 0.6, "diffuseTransmissionColorFactor": [1, 0.5, 0.3]}
        sheet = scene.material(0.0, extensions={"KHR_materials_diffuse_transmission": through})
        scene.mesh(quad((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)), scene.material(0.0))
        scene.mesh(quad((-8, 2, 8), (8, 2, 8), (8, 2, -8), (-8, 2, -8)), sheet)
        scene.light("directional", 1000, rotation=[-math.sqrt(0.5), 0, 0, math.sqrt(0.5)])
        side = 8 / 2
        corner = 1 / math.pi * side / math.hypot(1, side) * math.atan(side / math.hypot(1, side))
        return scene, ["--texels-per-metre", 4], self.at((0.1, 0, 0.1), (0, 1, 0), 1000 * 0.6 * (1.8 / 3) * 4 * corner)

    def test_on_by_a_closed_form_off_at_no_cost(self):
        # Effect; scene, options, judge; counters that tell of work when it is on. The three lights shine where nothing
        # can cast a shadow: they take no ray.
        table = [
            ("point_lights", self.analytic("point_light"), []),
            ("spot_lights", self.analytic("spot_light"), []),
            ("directional_lights", self.analytic("directional_light"), []),
            ("emitters", self.analytic("rect_light"), ["polygon factors"]),
            ("sky", self.analytic("sky_beside_wall"), ["rays to the sky"]),
            ("interreflection", self.analytic("furnace_0.8"), ["hemisphere rays", "links"]),
            ("shadows", self.analytic("penumbra"), ["shadow rays"]),
            ("textured_reflectance", self.textured_reflectance(), ["textured triangles"]),
            ("textured_emission", self.textured_emission(), ["textured triangles"]),
            ("alpha_cutout", self.analytic("alpha_mask"), ["alpha look-ups"]),
            ("alpha_blend", self.alpha_blend(), ["alpha look-ups"]),
            ("transmission", self.analytic("coloured_glass"), []),
            ("two_sided", self.two_sided(), ["two-sided triangles"]),
            ("diffuse_transmission", self.diffuse_transmission(), ["transmitting triangles"]),
        ]
        told = set()
        for effect, (scene, options, judge), counters in table:
            with self.subTest(effect):
                words = ["--target-error", "1%", "--no-batches", *options]
                bake = Bake(self, scene, *words)
                row = bake.effects[effect]
                self.assertTrue(row["on"], row)
                self.assertTrue(row["why"])
                judge(bake)
                for name in counters:
                    self.assertGreater(row["counters"][name], 0, name)
                self.assertNothingDone(bake)
                off = Bake(self, scene, *words[:1], "10%", *words[2:], "--effects", "-" + effect)
                self.assertFalse(off.effects[effect]["on"])
                self.assertTrue(off.effects[effect]["counters"])
                self.assertNothingDone(off)
            told.add(effect)
        # The rest have tests of their own above.
        self.assertEqual(set(bake.effects) - told, {"directional_lightmaps", "probes"})

    def assertNothingDone(self, bake):
        """What is off has counters of 0, all of them."""
        for effect in bake.effects.values():
            if not effect["on"] and effect["simulated"]:
                self.assertEqual(set(effect["counters"].values()), {0}, effect)


if __name__ == "__main__":
    programs.run(ProbesTest, DirectionalTest, Table)
