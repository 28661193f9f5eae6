#!/usr/bin/python3
"""What survives a bake: a file with a bit of everything, the scenes of the tests, and those beside the repository.

  structure_test.py --client LIGHTBATCH --daemon LIGHTBATCHD [--shared DIR]
"""
import copy
import pathlib
import struct
import sys

from programs import WithFolder, glb, run
import programs

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "peers"))
import gltf_file  # noqa: E402
import structure  # noqa: E402

FLOAT, SHORT, BYTE = (5126, "f"), (5123, "H"), (5121, "B")
LIT = ["--target-error", "50%", "--sky", "100", "--lightmap-size", "64"]


class Everything:
    """A file that holds what glTF lets a file hold."""

    def __init__(self):
        self.views, self.accessors, self.binary = [], [], b""
        quad = self.accessor(FLOAT, "VEC3", [0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0])
        normals = self.accessor(FLOAT, "VEC3", [0, 0, 1] * 4)
        indices = self.accessor(SHORT, "SCALAR", [0, 1, 2, 0, 2, 3])
        colours = self.accessor(BYTE, "VEC4", [255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 9, 9, 9, 255], normalized=True)
        morph = self.accessor(FLOAT, "VEC3", [0, 0, 0.5] * 4)
        joints = self.accessor(BYTE, "VEC4", [0, 1, 0, 0] * 4)
        weights = self.accessor(FLOAT, "VEC4", [0.5, 0.5, 0, 0] * 4)
        times = self.accessor(FLOAT, "SCALAR", [0, 0.25, 1])
        ways = self.accessor(FLOAT, "VEC3", [v / 7 for v in range(27)])
        swells = self.accessor(FLOAT, "SCALAR", [0, 1, 0.5])
        binds = self.accessor(FLOAT, "MAT4", [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] * 2)
        flat = {"POSITION": quad, "NORMAL": normals}

        def primitive(material, mode=4, **more):
            return {"attributes": {**flat, **more.pop("attributes", {})}, "indices": indices, "material": material, "mode": mode, **more}
        variants = {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [0], "name": "at night"}]}}
        meshes = [
            {"name": "mixed", "extras": {"sku": 7}, "primitives": [
                primitive(0, extras={"part": "front"}), primitive(1, 1), primitive(1, 0), primitive(2, 5), primitive(0, 6)]},
            {"name": "morphing", "weights": [0.25], "extras": {"targetNames": ["swell"]}, "primitives": [
                primitive(0, targets=[{"POSITION": morph}])]},
            {"name": "skinned", "primitives": [primitive(0, attributes={"JOINTS_0": joints, "WEIGHTS_0": weights})]},
            {"name": "varied", "primitives": [primitive(0, extensions=variants)]},
            {"name": "tagged", "primitives": [primitive(0, extensions={"ACME_tag": {"id": 3}})]},
            {"name": "coloured", "primitives": [primitive(2, attributes={"COLOR_0": colours})]},
            {"name": "shape", "primitives": [primitive(0)]}]
        nodes = [
            {"name": "root", "children": list(range(1, 15)), "extras": {"floor": [1, 2.5, None]}},
            {"name": "still", "mesh": 0, "extras": {"id": "a"}}, {"name": "twin", "mesh": 0, "translation": [2, 0, 0]},
            {"name": "moves", "mesh": 0, "translation": [4, 0, 0]}, {"name": "morphs", "mesh": 1, "weights": [0.75], "translation": [6, 0, 0]},
            {"name": "bends", "mesh": 2, "skin": 0}, {"name": "hip", "children": [7]}, {"name": "knee", "translation": [0, 1, 0]},
            {"name": "varies", "mesh": 3, "translation": [0, 2, 0]}, {"mesh": 4, "translation": [2, 2, 0]},
            {"name": "tagged", "mesh": 6, "translation": [4, 2, 0], "extensions": {"ACME_tag": {"mesh": 6}}},
            {"name": "eye", "camera": 0, "translation": [0, 1, 8]}, {"name": "lamp", "extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"name": "mirrored", "mesh": 5, "scale": [-1, 1, 1], "translation": [2, 4, 0]},
            {"name": "pointed at", "mesh": 6, "translation": [4, 4, 0]}, {"name": "elsewhere", "mesh": 6}, {"name": "both", "mesh": 6, "translation": [8, 0, 0]}]
        nodes[0]["children"].remove(7)
        colour = lambda r, **more: {"pbrMetallicRoughness": {"baseColorFactor": [r, 0.5, 0.5, 1], "metallicFactor": 0}, **more}  # noqa: E731
        self.document = {
            "asset": {"version": "2.0", "generator": "test", "copyright": "nobody", "extras": {"draft": True}},
            "scene": 1, "scenes": [{"name": "other", "nodes": [15, 16]}, {"name": "main", "nodes": [0, 16], "extras": {"mood": "grey"}}],
            "nodes": nodes, "meshes": meshes,
            "materials": [colour(0.2, name="red"), colour(0.8, name="pale", extras={"ral": 9001}), colour(0.4, doubleSided=True)],
            "skins": [{"name": "leg", "joints": [6, 7], "skeleton": 6, "inverseBindMatrices": binds, "extras": {"rig": 2}}],
            "cameras": [{"name": "wide", "type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.01}}],
            "animations": [
                {"name": "walk", "extras": {"loop": True},
                 "samplers": [{"input": times, "output": ways, "interpolation": "CUBICSPLINE"}, {"input": times, "output": swells}],
                 "channels": [{"sampler": 0, "target": {"node": 3, "path": "translation"}}, {"sampler": 1, "target": {"node": 4, "path": "weights"}}]},
                {"name": "pointer", "samplers": [{"input": times, "output": self.accessor(FLOAT, "VEC3", [0, 1, 2, 3, 4, 5, 6, 7, 8])}],
                 "channels": [{"sampler": 0, "target": {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/nodes/14/scale"}}}}]}],
            "extensionsUsed": ["ACME_tag", "KHR_animation_pointer", "KHR_lights_punctual", "KHR_materials_variants"],
            "extensions": {"ACME_tag": {"by": "us", "shapes": [{"mesh": 6}]}, "KHR_materials_variants": {"variants": [{"name": "night"}]},
                           "KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 50, "name": "bulb"}]}},
            "extras": {"project": "p"}, "accessors": self.accessors, "bufferViews": self.views, "buffers": [{"byteLength": len(self.binary)}]}

    def accessor(self, kind, shape, values, **more):
        self.binary += b"\0" * (-len(self.binary) % 4)
        data = struct.pack(f"<{len(values)}{kind[1]}", *values)
        self.views.append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)})
        self.binary += data
        width = gltf_file.WIDTHS[shape]
        entry = {"bufferView": len(self.views) - 1, "componentType": kind[0], "type": shape, "count": len(values) // width, **more}
        if kind == FLOAT and shape in ("VEC3", "SCALAR"):
            entry.update(min=[min(values[k::width]) for k in range(width)], max=[max(values[k::width]) for k in range(width)])
        self.accessors.append(entry)
        return len(self.accessors) - 1

    def write(self, path):
        pathlib.Path(path).write_bytes(glb(self.document, self.binary))
        return pathlib.Path(path)


class Structure(WithFolder):
    def check(self, scene, options):
        for result in structure.check(programs.OPTIONS.client, scene, pathlib.Path(self.path("out")), options):
            self.assertEqual(result.differences, [])

    def test_a_bit_of_everything(self):
        scene = Everything().write(self.path("everything.glb"))
        for options in (["--no-lightmaps"], ["--no-lightmaps", "--draws-share", "1", "--max-batches", "1"], LIT, [*LIT, "--no-batches"],
                        [*LIT, "--lights", "keep"]):
            with self.subTest(options=options):
                self.check(scene, options)

    def test_the_comparison_sees_what_is_lost(self):
        scene = Everything().write(self.path("everything.glb"))
        structure.check(programs.OPTIONS.client, scene, pathlib.Path(self.path("out")), ["--no-lightmaps"])
        written = structure.File(self.path("out", "scene.glb"))

        def batch(document):
            return next(n for n in document["nodes"] if n.get("extras", {}).get("lightbatch", {}).get("ranges"))
        losses = {
            "key": lambda d: d["accessors"][d["animations"][0]["samplers"][0]["input"]].update(count=2),
            "channel": lambda d: d["animations"][0]["channels"].pop(),
            "animation": lambda d: d["animations"].pop(), "joint": lambda d: d["skins"][0]["joints"].pop(),
            "bind matrix": lambda d: d["accessors"][d["skins"][0]["inverseBindMatrices"]].update(count=1),
            "camera": lambda d: d["cameras"][0]["perspective"].update(yfov=0.9), "name": lambda d: d["nodes"][7].pop("name"),
            "extras": lambda d: d["nodes"][1].pop("extras"), "material": lambda d: d["materials"][0].pop("name"),
            "scene": lambda d: d["scenes"][0]["nodes"].pop(), "mood": lambda d: d["scenes"][1]["extras"].pop("mood"),
            "variant": lambda d: d["extensions"].pop("KHR_materials_variants"), "light": lambda d: d["nodes"][12].pop("extensions"),
            "tag": lambda d: d["nodes"][10].pop("extensions"), "placement": lambda d: d["nodes"][3].update(translation=[4, 0, 1]),
            "lines": lambda d: d["meshes"][d["nodes"][1]["mesh"]]["primitives"].pop(),
            "morph": lambda d: d["meshes"][d["nodes"][4]["mesh"]]["primitives"][0].pop("targets"),
            "weights": lambda d: d["nodes"][4].pop("weights"), "range": lambda d: batch(d)["extras"]["lightbatch"]["ranges"].pop(),
            "source": lambda d: batch(d)["extras"]["lightbatch"]["ranges"][0].update(node=13), "asset": lambda d: d["asset"].pop("copyright"),
            "extension": lambda d: d["extensionsUsed"].remove("ACME_tag"), "child": lambda d: d["nodes"][6].pop("children")}
        for name, lose in losses.items():
            with self.subTest(lost=name):
                document = copy.deepcopy(written.json)
                lose(document)
                path = self.write("lost.glb", glb(document, written.glb.binary))
                self.assertNotEqual(structure.compare(scene, path).differences, [])

    def test_scenes(self):
        folders = [ROOT / "data/scenes"]
        if programs.OPTIONS.shared:
            folders.append(pathlib.Path(programs.OPTIONS.shared) / "scenes")
        for scene in sorted(s for folder in folders for s in folder.glob("*.glb")):
            with self.subTest(scene=scene.name):
                self.check(scene, ["--no-lightmaps"])


run(Structure)
