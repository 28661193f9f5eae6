"""Scenes made in code, written as .gltf with everything inside."""
import base64
import json
import struct
import zlib


class MadeScene:
    """Meshes of plain triangles, three vertices each; a node for every mesh, all under one root."""

    def __init__(self):
        self.materials, self.meshes, self.lights, self.nodes, self.ways, self.images, self.nearest = [], [], [], [], [], [], []
        self.instances = {}  # by place in nodes
        self.root = {"name": "root"}

    def material(self, reflectance=0.0, nits=0.0, double_sided=False, **more):
        """more: members of the glTF material; those of pbrMetallicRoughness and extensions are added to what is there."""
        material = {
            "pbrMetallicRoughness": {"baseColorFactor": [reflectance] * 3 + [1], "metallicFactor": 0},
            "emissiveFactor": [1, 1, 1] if nits > 0 else [0, 0, 0], "doubleSided": double_sided,
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": nits}} if nits > 0 else {}}
        for key, value in more.items():
            material[key] = {**material[key], **value} if key in ("pbrMetallicRoughness", "extensions") else value
        self.materials.append(material)
        return len(self.materials) - 1

    def texture(self, rows, nearest=False):
        """rows of (r, g, b, a) in 0..255; returns what a material's texture slot holds."""
        def chunk(kind, data):
            return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        raw = b"".join(b"\0" + bytes(v for pixel in row for v in pixel) for row in rows)
        self.images.append(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 6, 0, 0, 0)) +
                           chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b""))
        self.nearest.append(nearest)
        return {"index": len(self.images) - 1}

    def mesh(self, triangles, material, uv=None, colors=None, grid=None, instances=None, **node):
        """triangles: list of three points each, front counter-clockwise. uv: of a point, for textures; colors: of a point,
        its COLOR_0 (r, g, b, a). grid: positions are stored as 16-bit multiples of it. instances: translations of GPU instances."""
        self.meshes.append((list(triangles), material, uv, colors, grid))
        if grid:
            node = {"scale": [grid] * 3, **node}
        if instances:
            self.instances[len(self.nodes)] = instances
        self.nodes.append({"mesh": len(self.meshes) - 1, **node})

    def light(self, kind, intensity, properties=None, **node):
        """properties: further members of the light."""
        self.lights.append({"type": kind, "intensity": intensity, **(properties or {})})
        self.nodes.append({"extensions": {"KHR_lights_punctual": {"light": len(self.lights) - 1}}, **node})

    def animate(self, node, times, translations):
        """node: place in self.nodes."""
        self.ways.append((node + 1, times, translations))

    def write(self, path):
        data, views, accessors, meshes = bytearray(), [], [], []

        def accessor(kind, values, code="f", component=5126, stride=0, **more):
            """values: rows of numbers. Returns its index."""
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(values) * (stride or len(values[0]) * 4)})
            if stride:
                views[-1]["byteStride"] = stride
            for row in values:
                packed = struct.pack(f"<{len(row)}{code}", *row)
                data.extend(packed + bytes(max(0, stride - len(packed))))
            accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(values), "type": kind, **more})
            return len(accessors) - 1

        for triangles, material, uv, colors, grid in self.meshes:
            points = [p for t in triangles for p in t]
            stored = [[round(v / grid) for v in p] for p in points] if grid else points
            finite = [p for p in stored if all(v == v for v in p)]
            box = {"min": [min(p[k] for p in finite) for k in range(3)], "max": [max(p[k] for p in finite) for k in range(3)]}
            form = {"code": "h", "component": 5122, "stride": 8} if grid else {}
            attributes = {"POSITION": accessor("VEC3", stored, **form, **box)}
            if uv is not None:
                attributes["TEXCOORD_0"] = accessor("VEC2", [uv(p) for p in points])
            if colors is not None:
                attributes["COLOR_0"] = accessor("VEC4", [colors(p) for p in points])
            meshes.append({"primitives": [{"attributes": attributes, "material": material}]})
        nodes = list(self.nodes)
        for at, translations in self.instances.items():
            nodes[at] = {**nodes[at], "extensions": {"EXT_mesh_gpu_instancing": {
                "attributes": {"TRANSLATION": accessor("VEC3", translations)}}}}
        samplers, channels = [], []
        for node, times, translations in self.ways:
            at = accessor("SCALAR", [[t] for t in times], min=[min(times)], max=[max(times)])
            channels.append({"sampler": len(samplers), "target": {"node": node, "path": "translation"}})
            samplers.append({"input": at, "output": accessor("VEC3", translations)})
        root = {**self.root, "children": list(range(1, len(nodes) + 1))}
        quantized = {"KHR_mesh_quantization"} if any(m[4] for m in self.meshes) else set()
        document = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [root] + nodes,
            "meshes": meshes, "materials": self.materials, "accessors": accessors, "bufferViews": views,
            "buffers": [{"byteLength": len(data),
                         "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
            "extensions": {"KHR_lights_punctual": {"lights": self.lights}} if self.lights else {}}
        document["extensionsUsed"] = sorted(quantized | {"KHR_lights_punctual", "KHR_materials_emissive_strength"} | used(document))
        if quantized:
            document["extensionsRequired"] = sorted(quantized)
        if self.images:
            document["images"] = [{"uri": "data:image/png;base64," + base64.b64encode(i).decode()} for i in self.images]
            document["samplers"] = [{"wrapS": 33071, "wrapT": 33071},
                                    {"wrapS": 33071, "wrapT": 33071, "magFilter": 9728, "minFilter": 9728}]
            document["textures"] = [{"source": i, "sampler": int(n)} for i, n in enumerate(self.nearest)]
        if channels:
            document["animations"] = [{"channels": channels, "samplers": samplers}]
        with open(path, "w") as file:
            json.dump(document, file)


def used(value):
    """Names of all extensions in a piece of JSON."""
    if isinstance(value, list):
        return set().union(*map(used, value))
    if not isinstance(value, dict):
        return set()
    return set(value.get("extensions", {})).union(*map(used, value.values()))


def quad(a, b, c, d):
    """Two triangles, front counter-clockwise."""
    return [(a, b, c), (a, c, d)]


def box(low, high, inwards=True):
    """Six quads, fronts inwards or outwards."""
    v = [(low[0] if i & 1 == 0 else high[0], low[1] if i & 2 == 0 else high[1], low[2] if i & 4 == 0 else high[2])
         for i in range(8)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = []
    for f in faces:
        corners = [v[i] for i in f]
        triangles += quad(*(corners if inwards else corners[::-1]))
    return triangles
