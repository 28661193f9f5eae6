"""Scenes made in code, written as .gltf with everything inside."""
import base64
import json
import struct


class MadeScene:
    """Meshes of plain triangles, three vertices each; a node for every mesh, all under one root."""

    def __init__(self):
        self.materials, self.meshes, self.lights, self.nodes, self.ways = [], [], [], [], []
        self.root = {"name": "root"}

    def material(self, reflectance=0.0, nits=0.0, double_sided=False):
        self.materials.append({
            "pbrMetallicRoughness": {"baseColorFactor": [reflectance] * 3 + [1], "metallicFactor": 0},
            "emissiveFactor": [1, 1, 1] if nits > 0 else [0, 0, 0], "doubleSided": double_sided,
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": nits}} if nits > 0 else {}})
        return len(self.materials) - 1

    def mesh(self, triangles, material, **node):
        """triangles: list of three points each, front counter-clockwise."""
        self.meshes.append((list(triangles), material))
        self.nodes.append({"mesh": len(self.meshes) - 1, **node})

    def light(self, kind, intensity, **node):
        self.lights.append({"type": kind, "intensity": intensity})
        self.nodes.append({"extensions": {"KHR_lights_punctual": {"light": len(self.lights) - 1}}, **node})

    def animate(self, node, times, translations):
        """node: place in self.nodes."""
        self.ways.append((node + 1, times, translations))

    def write(self, path):
        data, views, accessors, meshes = bytearray(), [], [], []
        for triangles, material in self.meshes:
            points = [p for t in triangles for p in t]
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": 12 * len(points)})
            for p in points:
                data += struct.pack("<3f", *p)
            finite = [p for p in points if all(v == v for v in p)]
            accessors.append({"bufferView": len(views) - 1, "componentType": 5126, "count": len(points), "type": "VEC3",
                              "min": [min(p[k] for p in finite) for k in range(3)],
                              "max": [max(p[k] for p in finite) for k in range(3)]})
            meshes.append({"primitives": [{"attributes": {"POSITION": len(accessors) - 1}, "material": material}]})
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
            "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_emissive_strength"],
            "extensions": {"KHR_lights_punctual": {"lights": self.lights}} if self.lights else {}}
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
