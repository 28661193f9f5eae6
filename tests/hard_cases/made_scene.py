"""Scenes made in code, written as .gltf with everything inside."""
import base64
import json
import struct
import zlib


class MadeScene:
    """Meshes of plain triangles, three vertices each; a node for every mesh, all under one root."""

    def __init__(self):
        self.materials, self.meshes, self.lights, self.nodes, self.ways, self.images = [], [], [], [], [], []
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

    def texture(self, rows):
        """rows of (r, g, b, a) in 0..255; returns what a material's texture slot holds."""
        def chunk(kind, data):
            return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        raw = b"".join(b"\0" + bytes(v for pixel in row for v in pixel) for row in rows)
        self.images.append(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 6, 0, 0, 0)) +
                           chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b""))
        return {"index": len(self.images) - 1}

    def mesh(self, triangles, material, uv=None, **node):
        """triangles: list of three points each, front counter-clockwise. uv: of a point, for textures."""
        self.meshes.append((list(triangles), material, uv))
        self.nodes.append({"mesh": len(self.meshes) - 1, **node})

    def light(self, kind, intensity, **node):
        self.lights.append({"type": kind, "intensity": intensity})
        self.nodes.append({"extensions": {"KHR_lights_punctual": {"light": len(self.lights) - 1}}, **node})

    def animate(self, node, times, translations):
        """node: place in self.nodes."""
        self.ways.append((node + 1, times, translations))

    def write(self, path):
        data, views, accessors, meshes = bytearray(), [], [], []
        for triangles, material, uv in self.meshes:
            points = [p for t in triangles for p in t]
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": 12 * len(points)})
            for p in points:
                data += struct.pack("<3f", *p)
            finite = [p for p in points if all(v == v for v in p)]
            accessors.append({"bufferView": len(views) - 1, "componentType": 5126, "count": len(points), "type": "VEC3",
                              "min": [min(p[k] for p in finite) for k in range(3)],
                              "max": [max(p[k] for p in finite) for k in range(3)]})
            attributes = {"POSITION": len(accessors) - 1}
            if uv is not None:
                views.append({"buffer": 0, "byteOffset": len(data), "byteLength": 8 * len(points)})
                for p in points:
                    data += struct.pack("<2f", *uv(p))
                attributes["TEXCOORD_0"] = len(accessors)
                accessors.append({"bufferView": len(views) - 1, "componentType": 5126, "count": len(points), "type": "VEC2"})
            meshes.append({"primitives": [{"attributes": attributes, "material": material}]})
        samplers, channels = [], []
        for node, times, translations in self.ways:
            for values, kind in ((times, "SCALAR"), ([v for t in translations for v in t], "VEC3")):
                views.append({"buffer": 0, "byteOffset": len(data), "byteLength": 4 * len(values)})
                data += struct.pack(f"<{len(values)}f", *values)
                accessors.append({"bufferView": len(views) - 1, "componentType": 5126, "count": len(times), "type": kind})
            accessors[-2].update(min=[min(times)], max=[max(times)])
            channels.append({"sampler": len(samplers), "target": {"node": node, "path": "translation"}})
            samplers.append({"input": len(accessors) - 2, "output": len(accessors) - 1})
        root = {**self.root, "children": list(range(1, len(self.nodes) + 1))}
        document = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [root] + self.nodes,
            "meshes": meshes, "materials": self.materials, "accessors": accessors, "bufferViews": views,
            "buffers": [{"byteLength": len(data),
                         "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
            "extensionsUsed": sorted({"KHR_lights_punctual", "KHR_materials_emissive_strength"}.union(
                *(m["extensions"] for m in self.materials))),
            "extensions": {"KHR_lights_punctual": {"lights": self.lights}} if self.lights else {}}
        if self.images:
            document["images"] = [{"uri": "data:image/png;base64," + base64.b64encode(i).decode()} for i in self.images]
            document["samplers"] = [{"wrapS": 33071, "wrapT": 33071}]
            document["textures"] = [{"source": i, "sampler": 0} for i in range(len(self.images))]
        if channels:
            document["animations"] = [{"channels": channels, "samplers": samplers}]
        with open(path, "w") as file:
            json.dump(document, file)


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
