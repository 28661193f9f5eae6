#!/usr/bin/python3
"""What becomes of a scene's lights: relight against a fresh bake with the new values, and bakes that leave the lights in.

  lights_test.py --client LIGHTBATCH
"""
import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "peers"), str(HERE.parent / "hard_cases")]
import exr_file  # noqa: E402
import gltf_file  # noqa: E402
import points  # noqa: E402
from made_scene import MadeScene, box, quad  # noqa: E402

CLIENT = None
TARGET = 0.02


def lightbatch(*words):
    return subprocess.run([CLIENT, *map(str, words)], capture_output=True, text=True)


def room(path, lamp, sun, nits, color=(1, 1, 1)):
    """A room without a ceiling: a point light, a sun, an emitting sheet."""
    scene = MadeScene()
    grey, glow = scene.material(0.6), scene.material(0.0, nits=nits)
    scene.mesh([t for t in box((0, 0, 0), (4, 2.5, 3)) if not all(p[1] == 2.5 for p in t)], grey)
    scene.mesh(quad((1, 2, 1), (2, 2, 1), (2, 2, 2), (1, 2, 2)), glow)
    scene.mesh(box((2.5, 0, 1), (3.2, 1.0, 1.8), inwards=False), grey)
    scene.light("point", lamp, translation=[3, 1.8, 2.2])
    scene.lights[-1]["color"] = list(color)
    scene.light("directional", sun, rotation=[-0.64, 0.1, 0.05, 0.76])
    scene.write(path)


def page(folder):
    rgb, coverage = exr_file.read_rgb(folder / "lightmap_0.exr")
    return np.asarray(rgb, float), np.asarray(coverage, float)


def about(folder):
    return gltf_file.Glb(folder / "scene.glb").json


class Relight(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.kept = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.kept.name)
        room(cls.folder / "old.gltf", lamp=300, sun=500, nits=100)
        room(cls.folder / "new.gltf", lamp=900, sun=100, nits=250, color=(1, 0.5, 0.25))
        for name, sky in (("old", 100), ("new", 40)):
            done = lightbatch("bake", cls.folder / f"{name}.gltf", "-o", cls.folder / name, "--sky", sky,
                              "--target-error", TARGET, "--texels-per-metre", 8, "--lightmap-size", 1024)
            assert done.returncode in (0, 4), done.stderr
        cls.lights = cls.folder / "lights.json"
        cls.lights.write_text(json.dumps({
            "lights": {"0": {"intensity": 900, "color": [1, 0.5, 0.25]}, "1": {"intensity": 100}},
            "materials": {"1": {"emissiveStrength": 250}}, "sky": 40}))
        done = lightbatch("relight", cls.folder / "old", "--lights", cls.lights, "-o", cls.folder / "relit")
        assert done.returncode == 0, done.stderr

    @classmethod
    def tearDownClass(cls):
        cls.kept.cleanup()

    def test_groups_add_up_to_the_lightmap(self):
        old, coverage = page(self.folder / "old")
        report = json.loads((self.folder / "old" / "report.json").read_text())
        self.assertEqual({g["layer"] for g in report["light_groups"]}, {"light_0", "light_1", "material_1", "sky"})
        unchanged = self.folder / "nothing.json"
        unchanged.write_text("{}")
        large = self.folder / "old" / "large.bin"
        large.touch()
        os.truncate(large, 1 << 40)  # no file of a bake: not sent
        self.addCleanup(large.unlink)
        done = lightbatch("relight", self.folder / "old", "--lights", unchanged, "-o", self.folder / "same")
        self.assertEqual(done.returncode, 0, done.stderr)
        same, _ = page(self.folder / "same")
        lit = coverage > 0
        # Half floats: 11 bits.
        self.assertLess(np.abs(same[lit] - old[lit]).max(), 2e-3 * old[lit].max())

    def test_equals_a_fresh_bake(self):
        relit, coverage = page(self.folder / "relit")
        fresh, _ = page(self.folder / "new")
        lit = coverage > 0
        mean = fresh[lit].mean()
        # Either bake has its own noise of the target at most; their means may differ by a tenth of it.
        rms = np.sqrt(((relit[lit] - fresh[lit]) ** 2).mean()) / mean
        bias = (relit[lit].mean() - mean) / mean
        print(f"relit against fresh: rms {100 * rms:.2f} %, mean {100 * bias:+.3f} %")
        self.assertLess(rms, np.sqrt(2) * TARGET)
        self.assertLess(abs(bias), TARGET / 10)

    def test_scene_holds_the_new_values(self):
        was, now = about(self.folder / "old"), about(self.folder / "relit")
        taken = now["scenes"][0]["extras"]["lightbatch"]["lights"]
        self.assertEqual([t["light"]["intensity"] for t in taken], [900, 100])
        self.assertEqual(taken[0]["light"]["color"], [1, 0.5, 0.25])
        strengths = {m["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] for m in now["materials"]
                     if "KHR_materials_emissive_strength" in m.get("extensions", {})}
        self.assertEqual(strengths, {250})
        self.assertEqual(was["meshes"], now["meshes"])
        # The page in the file is the page beside it.
        glb = gltf_file.Glb(self.folder / "relit" / "scene.glb")
        self.assertEqual(len(gltf_file.LitTriangles(glb).page_names), 1)

    def test_may_be_relit_again(self):
        back = self.folder / "back.json"
        back.write_text(json.dumps({
            "lights": {"0": {"intensity": 300, "color": [1, 1, 1]}, "1": {"intensity": 500}},
            "materials": {"1": {"emissiveStrength": 100}}, "sky": 100}))
        done = lightbatch("relight", self.folder / "relit", "--lights", back, "-o", self.folder / "back")
        self.assertEqual(done.returncode, 0, done.stderr)
        old, coverage = page(self.folder / "old")
        again, _ = page(self.folder / "back")
        lit = coverage > 0
        self.assertLess(np.abs(again[lit] - old[lit]).max(), 2e-3 * old[lit].max())

    def test_refuses_what_it_cannot_know(self):
        for words, part in (({"lights": {"7": {"intensity": 1}}}, "no light of this name"),
                            ({"lights": {"0": {"range": 1}}}, "no such field"),
                            ({"lights": {"0": {"intensity": -1}}}, "at least 0"),
                            ({"lights": {"0": {"color": [1, 2]}}}, "three numbers"),
                            ({"fog": 1}, "no such field")):
            bad = self.folder / "bad.json"
            bad.write_text(json.dumps(words))
            done = lightbatch("relight", self.folder / "old", "--lights", bad, "-o", self.folder / "none")
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(part, done.stderr)
            self.assertFalse((self.folder / "none").exists())

    def test_refuses_broken_bakes(self):
        """Whatever the folder of a bake holds: an answer, no crash, no file."""
        broken, words = self.folder / "broken", self.folder / "words.json"
        words.write_text(json.dumps({"lights": {"0": {"intensity": 600}}}))
        shutil.copytree(self.folder / "old", broken)
        report = json.loads((broken / "report.json").read_text())
        group = report["light_groups"][0]
        page_file, layer_file = (broken / "lightmap_0.exr"), (broken / "light_groups_0.exr")
        whole = page_file.read_bytes(), layer_file.read_bytes()

        def refused(place, **changes):
            (broken / "report.json").write_text(json.dumps({**report, **changes}))
            done = lightbatch("relight", broken, "--lights", words, "-o", self.folder / "none")
            self.assertIn(done.returncode, (2, 3), f"{changes.keys()}: {done.returncode} {done.stderr}")
            self.assertIn(place, done.stderr)
            self.assertFalse((self.folder / "none").exists())

        for groups in ([], None, 5, {}, "light"):
            refused("light_groups", light_groups=groups)
        for bad in ({"index": -1}, {"color": [1, 1]}, {"color": [1e300, 1, 1]}, {"intensity": None}, {"layer": 3}):
            refused("light_groups/0", light_groups=[{**group, **bad}] + report["light_groups"][1:])
        for bad in ({"layer": "none"}, {"layer": ""}):
            refused("layer", light_groups=[{**group, **bad}] + report["light_groups"][1:])
        refused("times as strong", light_groups=[{**group, "intensity": 1e-30}] + report["light_groups"][1:],
                relit=[{**group, "intensity": 1e30}] + report["light_groups"][1:])
        refused("relit", relit=[group])
        refused("report.json", lightmaps={"pages": 5})
        refused("lightmap_1.exr", lightmaps={"pages": [{}] * 1000})
        for path, bytes_of, other in ((page_file, whole[0], whole[1]), (layer_file, whole[1], whole[0])):
            for content in (b"", bytes_of[:100], bytes_of[:-100], other):
                path.write_bytes(content)
                refused(".exr")
            path.write_bytes(bytes_of)

    def test_a_report_of_other_shapes_does_no_harm(self):
        odd, words = self.folder / "odd", self.folder / "nothing_new.json"
        words.write_text("{}")
        shutil.copytree(self.folder / "old", odd)
        report = json.loads((odd / "report.json").read_text())
        for value in (5, "x", None, [], {}, [5], {"a": {"b": [None]}}):
            kept = {k: v if k in ("light_groups", "lightmaps") else value for k, v in report.items()}
            (odd / "report.json").write_text(json.dumps(kept))
            done = lightbatch("relight", odd, "--lights", words, "-o", self.folder / "odd_out")
            self.assertIn(done.returncode, (0, 3), f"{value}: {done.returncode} {done.stderr}")


class LightsKept(unittest.TestCase):
    def test_only_indirect_light_is_baked(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            room(folder / "room.gltf", lamp=300, sun=0, nits=50)
            for policy in ("keep", "remove"):
                done = lightbatch("bake", folder / "room.gltf", "-o", folder / policy, "--lights", policy,
                                  "--target-error", TARGET, "--texels-per-metre", 8)
                self.assertIn(done.returncode, (0, 4), done.stderr)
            kept, whole = points.Bake(folder / "keep"), points.Bake(folder / "remove")
            self.assertIn("KHR_lights_punctual", about(folder / "keep").get("extensionsUsed", []))
            self.assertNotIn("KHR_lights_punctual", about(folder / "remove").get("extensionsUsed", []))
            light, up = np.array([3, 1.8, 2.2]), np.array([0, 1, 0])
            for x, z in ((0.5, 2.6), (1.6, 2.4), (2.2, 2.8)):
                at = np.array([x, 0, z])
                to = light - at
                both = kept.irradiance(at, up)[0] + 300 * to[1] / np.linalg.norm(to) ** 3
                self.assertLess(abs(both / whole.irradiance(at, up)[0] - 1), 0.05)
            report = json.loads((folder / "keep" / "report.json").read_text())
            self.assertLess(report["accuracy"]["certified"], 2 * TARGET)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--client", required=True)
    words, rest = parser.parse_known_args()
    CLIENT = words.client
    unittest.main(argv=[sys.argv[0], *rest])
