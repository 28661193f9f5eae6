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
import gltf_file  # noqa: E402
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


class ProbesTest(WithFolder):
    def scene(self, name):
        path = os.path.join(programs.OPTIONS.shared, "scenes", name)
        if not os.path.exists(path):
            self.skipTest(f"{name} is not here")
        return path

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


if __name__ == "__main__":
    programs.run(ProbesTest)
