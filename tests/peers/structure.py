#!/usr/bin/python3
"""What a file keeps when lightbatch reorganises it: everything but where triangles are drawn.

  structure.py [--scenes DIR] [--out DIR] [--lightbatch FILE] [--no-npm] [--option=OPTION] [SCENE...]

Bakes each .glb of DIR (or the named ones) and compares input and output entry by entry: animations with all keys, skins,
cameras, scenes, names, extras, custom extensions, images, materials; for every node the triangles of each material and
variant that it draws, in its own mesh, in batches or as instances; lines, points, morph targets and skinned primitives
value by value. With npm, the Khronos validator's errors and warnings too. One line for each scene; exit code 0: nothing is
lost anywhere and the validator finds nothing new.

Values inside meshopt and Draco streams cannot be read here: there counts and types are compared, and a second, uncompressed
output with the input as lightbatch decodes it, value by value.
"""
import argparse
import collections
import hashlib
import json
import pathlib
import shutil
import sys

import numpy as np

import gltf_file
import table

COMPRESSION = {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_mesh_quantization"}
INSTANCING, LIGHTS, VARIANTS = "EXT_mesh_gpu_instancing", "KHR_lights_punctual", "KHR_materials_variants"
TRIANGLES, STRIP, FAN = 4, 5, 6
# The product drops triangles lower than 1e-7 of their longest edge, in floats: here rounding is left some room.
FLAT, ROUNDING = 1e-6, 4 * float(np.finfo(np.float32).eps)


def without(entry, *keys):
    return {k: v for k, v in entry.items() if k not in keys}


def without_extensions(entry, names):
    """The entry without these extensions, and without an empty list of them."""
    kept = without(entry.get("extensions", {}), *names)
    return without(entry, "extensions") | ({"extensions": kept} if kept else {})


def without_note(entry):
    """The entry without what lightbatch says about itself in extras."""
    kept = entry.get("extras")
    if isinstance(kept, dict):
        kept = without(kept, "lightbatch") or None
    return without(entry, "extras") | ({"extras": kept} if kept is not None else {})


class File:
    """A .glb with the questions that the comparison asks."""

    def __init__(self, path):
        self.glb = gltf_file.Glb(path)
        self.json = self.glb.json
        self.worlds = collections.defaultdict(list)  # by identity of the node
        for node, world in self.glb.world_nodes():
            self.worlds[id(node)].append(world)

    def list(self, name):
        return self.json.get(name, [])

    def bytes_of(self, view):
        view = self.json["bufferViews"][view]
        if "EXT_meshopt_compression" in view.get("extensions", {}):
            return None
        start = view.get("byteOffset", 0)
        return self.glb.binary[start:start + view["byteLength"]]

    def digest(self, view):
        return hashlib.sha256(self.bytes_of(view)).hexdigest()

    def values(self, index):
        """What an accessor holds; without "sha256" where a compressed stream holds it."""
        accessor = self.json["accessors"][index]
        about = {k: accessor.get(k) for k in ("componentType", "type", "count", "name", "extras")}
        about["normalized"] = accessor.get("normalized", False)
        sparse = accessor.get("sparse")
        for view in [accessor.get("bufferView")] + ([sparse[k]["bufferView"] for k in ("indices", "values")] if sparse else []):
            if view is not None and self.bytes_of(view) is None:
                return about
        if "bufferView" in accessor or sparse:
            values = self.glb.raw(index)
            if sparse:
                kinds = {"indices": ("SCALAR", sparse["indices"]["componentType"]), "values": (accessor["type"], accessor["componentType"])}
                parts = {}
                for part, (kind, component) in kinds.items():
                    start = sparse[part].get("byteOffset", 0)
                    count = sparse["count"] * gltf_file.WIDTHS[kind]
                    parts[part] = np.frombuffer(self.bytes_of(sparse[part]["bufferView"]), gltf_file.COMPONENTS[component], count, start)
                values[parts["indices"]] = parts["values"].reshape(sparse["count"], -1)
            about["sha256"] = hashlib.sha256(values.tobytes()).hexdigest()
        return about

    def triangles(self, primitive):
        """How many, or None for lines, points and what has no positions."""
        if "POSITION" not in primitive["attributes"]:
            return None
        mode = primitive.get("mode", TRIANGLES)
        source = primitive["indices"] if "indices" in primitive else primitive["attributes"]["POSITION"]
        count = self.json["accessors"][source]["count"]
        return count // 3 if mode == TRIANGLES else max(count - 2, 0) if mode in (STRIP, FAN) else None

    def flat(self, primitive, world):
        """How many triangles may count as without area in the world; unknown, so all, in a compressed primitive."""
        position = self.json["accessors"][primitive["attributes"]["POSITION"]]
        if "bufferView" not in position or self.bytes_of(position["bufferView"]) is None:
            return self.triangles(primitive)
        corners = self.glb.values(primitive["attributes"]["POSITION"]) @ world[:3, :3].T + world[:3, 3]
        order = self.glb.raw(primitive["indices"])[:, 0].astype(int) if "indices" in primitive else np.arange(len(corners))
        if primitive.get("mode", TRIANGLES) != TRIANGLES:
            first = np.arange(len(order) - 2)
            fan = primitive["mode"] == FAN
            order = np.stack([order[0 * first if fan else first], order[first + 1], order[first + 2]], 1)
        a, b, c = np.moveaxis(corners[order.reshape(-1, 3)], 1, 0)
        longest = np.max([np.linalg.norm(e, axis=1) for e in (b - a, c - b, a - c)], axis=0)
        height = np.maximum(FLAT * longest, ROUNDING * np.abs(corners).max(initial=0))
        return int((np.linalg.norm(np.cross(b - a, c - a), axis=1) <= height * longest).sum())

    def content(self, primitive):
        """All of a primitive."""
        shown = without_extensions(primitive, COMPRESSION)
        shown["attributes"] = {k: self.values(v) for k, v in sorted(primitive["attributes"].items())}
        shown["targets"] = [{k: self.values(v) for k, v in sorted(t.items())} for t in primitive.get("targets", [])]
        if "indices" in primitive:
            shown["indices"] = self.values(primitive["indices"])
        return shown

    def look(self, material):
        """A material apart from its lightmap and from the numbers of texture coordinates, which the lightmap may move."""
        entry = {} if material is None else self.json["materials"][material]

        def plain(entry):
            if isinstance(entry, dict):
                return {k: plain(v) for k, v in entry.items() if k not in ("MOZ_lightmap", "texCoord") and (k != "extensions" or set(v) - {"MOZ_lightmap"})}
            if isinstance(entry, list):
                return [plain(v) for v in entry]
            return entry if isinstance(entry, (str, bool)) or entry is None else float(entry)
        return json.dumps(plain(entry), sort_keys=True)

    def looks(self, primitive, material=None):
        """Material and variants of a primitive; `material` stands for its own where vertices hold the colour."""
        mappings = primitive.get("extensions", {}).get(VARIANTS, {}).get("mappings", [])
        return json.dumps([self.look(primitive.get("material") if material is None else material),
                           [[self.look(m["material"]), without(m, "material")] for m in mappings]], sort_keys=True)

    def instances(self, node):
        attributes = node.get("extensions", {}).get(INSTANCING, {}).get("attributes", {})
        return self.json["accessors"][next(iter(attributes.values()))]["count"] if attributes else 1

    def primitives(self, node):
        return self.json["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []


def agrees(a, b):
    """Equal, but for values that only one side can read."""
    if isinstance(a, dict) and isinstance(b, dict):
        known = {"sha256"} if a.keys() ^ b.keys() == {"sha256"} else set()
        return a.keys() - known == b.keys() - known and all(agrees(a[k], b[k]) for k in a.keys() - known)
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(agrees, a, b))
    return a == b


class Comparison:
    """Differences between two files, as sentences."""

    def __init__(self, before, after, lit=False):
        self.before, self.after, self.lit = before, after, lit
        self.differences, self.counts = [], collections.Counter()
        self.compare_lists()
        self.compare_root()
        self.compare_nodes()
        self.compare_pinned_meshes()

    def same(self, place, a, b):
        if not agrees(a, b):
            self.differences.append(f"{place}: {json.dumps(a)[:160]} became {json.dumps(b)[:160]}")

    def compare_list(self, name, shown):
        a, b = self.before.list(name), self.after.list(name)
        if len(b) < len(a):
            self.differences.append(f"{name}: {len(a)} became {len(b)}")
        for i, (x, y) in enumerate(zip(a, b)):
            self.same(f"{name}/{i}", shown(self.before, x), shown(self.after, y))
        self.counts[name] = len(a)

    def compare_lists(self):
        def animation(file, entry):
            samplers = [{**s, "input": file.values(s["input"]), "output": file.values(s["output"])} for s in entry["samplers"]]
            return {**entry, "samplers": samplers}

        def skin(file, entry):
            matrices = entry.get("inverseBindMatrices")
            return {**entry, "inverseBindMatrices": None if matrices is None else file.values(matrices)}

        def image(file, entry):
            return {**entry, "bufferView": file.digest(entry["bufferView"])} if "bufferView" in entry else entry

        def scene(file, entry):
            return without(without_note(entry), "nodes")

        as_is = lambda _, entry: entry  # noqa: E731
        for name, shown in (("animations", animation), ("skins", skin), ("images", image), ("scenes", scene),
                            ("materials", as_is), ("textures", as_is), ("samplers", as_is), ("cameras", as_is)):
            self.compare_list(name, shown)
        for entry in self.before.list("animations"):
            self.counts["keys"] += sum(self.before.json["accessors"][s["input"]]["count"] for s in entry["samplers"])

    def compare_root(self):
        a, b = self.before.json, self.after.json
        gone = {LIGHTS} if self.lit else set()
        for key in ("asset", "scene"):
            self.same(key, a.get(key), b.get(key))
        self.same("extensions", without(a.get("extensions", {}), *gone), without(b.get("extensions", {}), LIGHTS if self.lit else ""))
        self.same("extras", without_note(a).get("extras"), without_note(b).get("extras"))
        lost = set(a.get("extensionsUsed", [])) - set(b.get("extensionsUsed", [])) - COMPRESSION - {INSTANCING} - gone
        self.same("extensionsUsed", [], sorted(lost))
        for i, (x, y) in enumerate(zip(self.before.list("scenes"), self.after.list("scenes"))):
            kept, more = y.get("nodes", [])[:len(x.get("nodes", []))], y.get("nodes", [])[len(x.get("nodes", [])):]
            self.same(f"scenes/{i}/nodes", x.get("nodes", []), kept)
            self.same(f"scenes/{i}/nodes added", [], [n for n in more if self.after.json["nodes"][n].get("name") != "lightbatch"])

    def drawn_elsewhere(self):
        """For each input node, what new nodes draw of it: (looks, name and extras of mesh, extras of primitive) -> triangles."""
        drawn = collections.defaultdict(collections.Counter)
        for node in self.after.list("nodes")[len(self.before.list("nodes")):]:
            note = node.get("extras", {}).get("lightbatch", {})
            primitives = self.after.primitives(node)
            for r in note.get("ranges", []) if "nodes" not in note else []:
                mesh = self.before.list("meshes")[self.before.list("nodes")[r["node"]]["mesh"]]
                self.same(f"name of the mesh of nodes/{r['node']}", mesh.get("name", r["name"]), r.get("mesh", r["name"]))
                self.same(f"extras of the mesh of nodes/{r['node']}", mesh.get("extras"), r.get("mesh_extras"))
                looks = self.after.looks(primitives[r["primitive"]], r.get("material"))
                drawn[r["node"]][looks, json.dumps(r.get("primitive_extras"), sort_keys=True)] += r["count"] // 3
            for source in note.get("nodes", []):
                mesh = self.before.list("meshes")[self.before.list("nodes")[source]["mesh"]]
                copy = self.after.list("meshes")[node["mesh"]]
                for key in ("name", "extras"):
                    self.same(f"{key} of the mesh of nodes/{source}", mesh.get(key), copy.get(key))
                for r in note.get("ranges") or [{"primitive": i} for i in range(len(primitives))]:
                    p = primitives[r["primitive"]]
                    count = r["count"] // 3 if "count" in r else self.after.triangles(p)
                    drawn[source][self.after.looks(p, r.get("material")), json.dumps(r.get("primitive_extras", p.get("extras")), sort_keys=True)] += count
        return drawn

    def compare_nodes(self):
        elsewhere = self.drawn_elsewhere()
        gone = {INSTANCING, LIGHTS} if self.lit else {INSTANCING}
        for i, (x, y) in enumerate(zip(self.before.list("nodes"), self.after.list("nodes"))):
            plain = lambda node: without(without_extensions(node, gone), "mesh", "children")  # noqa: E731
            self.same(f"nodes/{i}", plain(x), plain(y))
            children = y.get("children", [])
            self.same(f"nodes/{i}/children", x.get("children", []), children[:len(x.get("children", []))])
            if not self.lit:
                self.same(f"nodes/{i}/children added", [], children[len(x.get("children", [])):])
            self.compare_drawn(i, x, y, elsewhere[i])
            self.counts["extras"] += "extras" in x
        self.counts["nodes"] = len(self.before.list("nodes"))
        self.same("nodes lost", [], list(range(len(self.after.list("nodes")), len(self.before.list("nodes")))))

    def compare_drawn(self, index, x, y, drawn):
        """The primitives of one node."""
        place = f"nodes/{index}"
        keep_whole = lambda f, p, node: f.triangles(p) is None or "targets" in p or "skin" in node  # noqa: E731
        whole = [[f.content(p) for p in f.primitives(n) if keep_whole(f, p, n)] for f, n in ((self.before, x), (self.after, y))]
        self.same(f"{place}: lines, points, morphing and skinned primitives", *whole)
        self.counts["lines and points"] += sum(p.get("mode", TRIANGLES) < TRIANGLES for p in self.before.primitives(x))
        self.counts["morphing"] += sum("targets" in p for p in self.before.primitives(x))
        if whole[0] and "mesh" in y:
            a, b = self.before.json["meshes"][x["mesh"]], self.after.json["meshes"][y["mesh"]]
            self.same(f"{place}/mesh", without(a, "primitives"), without(b, "primitives"))
        expected, flat, worlds = collections.Counter(), 0, self.before.worlds[id(x)]
        for p in self.before.primitives(x):
            if self.before.triangles(p) is not None:
                expected[self.before.looks(p), json.dumps(p.get("extras"), sort_keys=True)] += self.before.triangles(p) * self.before.instances(x)
                flat += sum(self.before.flat(p, world) for world in worlds)
        after_nodes = self.after.list("nodes")
        own = [y] + [after_nodes[c] for c in y.get("children", [])[len(x.get("children", [])):]]
        for node in own:
            for p in self.after.primitives(node):
                if self.after.triangles(p) is not None:
                    drawn[self.after.looks(p), json.dumps(p.get("extras"), sort_keys=True)] += self.after.triangles(p) * self.after.instances(node)
        missing, more = expected - drawn, drawn - expected
        if more or missing.total() > flat:
            self.differences.append(f"{place}: {missing.total()} triangles of {expected.total()} missing, {more.total()} too many ({flat} without area)")
        self.counts["triangles"] += expected.total()
        self.counts["dropped without area"] += missing.total()

    def compare_pinned_meshes(self):
        """Meshes that unknown extensions name by number."""
        def numbers(entry, below):
            if isinstance(entry, dict):
                for key, value in entry.items():
                    if below and key == "mesh" and isinstance(value, int):
                        yield value
                    yield from numbers(value, below or key == "extensions")
            elif isinstance(entry, list):
                for value in entry:
                    yield from numbers(value, below)
        for mesh in sorted(set(numbers(self.before.json, False))):
            contents = []
            for file in (self.before, self.after):
                entry = file.list("meshes")[mesh] if mesh < len(file.list("meshes")) else {"primitives": []}
                contents.append([without(entry, "primitives"), [file.content(p) for p in entry["primitives"]]])
            self.same(f"meshes/{mesh}, which an extension names", *contents)
            self.counts["pinned meshes"] += 1


def compare(before, after, lit=False):
    return Comparison(File(before), File(after), lit)


def is_compressed(path):
    return bool({"KHR_draco_mesh_compression", "EXT_meshopt_compression"} & set(File(path).json.get("extensionsUsed", [])))


def check(lightbatch, scene, out, options):
    """Bakes a scene into out/scene.glb and returns the comparisons: as it comes and, of a compressed file, decoded too."""
    def bake(folder, *more):
        shutil.rmtree(folder, ignore_errors=True)
        code = table.bake(lightbatch, scene, folder, [*options, *more])[0]
        if code not in (0, 4):
            raise RuntimeError(f"{scene}: exit code {code}; see {folder}.log")
        return folder / "scene.glb"
    lit = "--no-lightmaps" not in options
    results = [compare(scene, bake(out), lit)]
    if is_compressed(scene):
        plain = bake(out.with_name(out.name + ".plain"), "--compress", "none")
        decoded = out.with_name(out.name + ".decoded")
        shutil.rmtree(decoded, ignore_errors=True)
        table.bake(lightbatch, scene, decoded, ["--no-batches", "--no-lightmaps", "--compress", "none"])
        results.append(compare(decoded / "scene.glb", plain, lit))
    return results


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=pathlib.Path, default=table.ROOT / "tests/data/scenes")
    parser.add_argument("--out", type=pathlib.Path, default=table.ROOT / "build/structure")
    parser.add_argument("--lightbatch", type=pathlib.Path, default=table.ROOT / "build/release/client/cli/lightbatch")
    parser.add_argument("--option", action="append", default=[], help="of bake, as --option=--seed=2 (default: --no-lightmaps)")
    parser.add_argument("--no-npm", action="store_true")
    parser.add_argument("names", nargs="*", metavar="SCENE")
    words = parser.parse_args()
    words.out.mkdir(parents=True, exist_ok=True)
    checks = table.Checks(words.out, not words.no_npm, False)
    options = words.option or ["--no-lightmaps"]
    failed = 0
    for name in words.names or sorted(path.stem for path in words.scenes.glob("*.glb")):
        scene, out = words.scenes / f"{name}.glb", words.out / name
        results = check(words.lightbatch, scene, out, options)
        differences = [d for result in results for d in result.differences]
        validator, worse = checks.validator(scene, out / "scene.glb")
        failed += worse or bool(differences)
        kept = ", ".join(f"{count} {what}" for what, count in results[-1].counts.items() if count)
        print(f"{name}: {'LOST' if differences else 'kept'} {kept}; validator {validator}{' WORSE' if worse else ''}")
        for difference in differences[:20]:
            print(f"  {difference}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
