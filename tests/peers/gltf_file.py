"""Reads a .glb as numpy arrays: what a renderer needs to look a lightmap up. Core glTF 2.0, KHR_mesh_quantization,
EXT_mesh_gpu_instancing and MOZ_lightmap; no compressed meshes (lightbatch writes none)."""
import json
import pathlib
import struct

import numpy as np

COMPONENTS = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
TRIANGLES = 4


class Glb:
    def __init__(self, path):
        data = pathlib.Path(path).read_bytes()
        magic, version, _ = struct.unpack_from("<III", data)
        if magic != 0x46546C67 or version != 2:
            raise ValueError(f"{path}: no glTF 2.0 binary")
        size = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20:20 + size])
        self.binary = data[20 + size + 8:]

    def raw(self, index):
        """Values of an accessor as stored, (count, components)."""
        accessor = self.json["accessors"][index]
        kind, width = np.dtype(COMPONENTS[accessor["componentType"]]), WIDTHS[accessor["type"]]
        if "bufferView" not in accessor:
            return np.zeros((accessor["count"], width), kind)
        view = self.json["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", kind.itemsize * width)
        return np.ndarray((accessor["count"], width), kind, self.binary, start, (stride, kind.itemsize)).copy()

    def values(self, index):
        """Values of an accessor in double; normalised integers mapped to [0, 1] or [-1, 1]."""
        values, kind = self.raw(index), self.json["accessors"][index]["componentType"]
        out = values.astype(np.float64)
        if self.json["accessors"][index].get("normalized"):
            out = np.maximum(out / float(np.iinfo(COMPONENTS[kind]).max), -1.0)
        return out

    def is_compressed(self, index):
        view = self.json["accessors"][index].get("bufferView")
        return view is not None and "EXT_meshopt_compression" in self.json["bufferViews"][view].get("extensions", {})

    def world_nodes(self):
        """(node, 4x4 world matrix) of every node of the default scene, GPU instances one by one; without what compressed
        attributes say of them."""
        nodes = self.json.get("nodes", [])
        scenes = self.json.get("scenes", [{}])
        open_ = [(i, np.eye(4)) for i in scenes[self.json.get("scene", 0)].get("nodes", [])]
        while open_:
            index, parent = open_.pop()
            node = nodes[index]
            world = parent @ local_matrix(node)
            open_ += [(child, world) for child in node.get("children", [])]
            instancing = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
            if instancing is None:
                yield node, world
                continue
            accessors = instancing["attributes"]
            count = self.json["accessors"][next(iter(accessors.values()))]["count"]
            attributes = {k: self.values(v) for k, v in accessors.items() if not self.is_compressed(v)}
            for i in range(count):
                yield node, world @ trs(attributes["TRANSLATION"][i] if "TRANSLATION" in attributes else [0, 0, 0],
                                        attributes["ROTATION"][i] if "ROTATION" in attributes else [0, 0, 0, 1],
                                        attributes["SCALE"][i] if "SCALE" in attributes else [1, 1, 1])

    def lightmap_of(self, material):
        """(name of the lightmap's image, intensity) of a material, or None."""
        if material is None:
            return None
        info = self.json["materials"][material].get("extensions", {}).get("MOZ_lightmap")
        if info is None:
            return None
        if info.get("texCoord", 0) != 1:
            raise ValueError(f"materials/{material}: MOZ_lightmap reads TEXCOORD_{info.get('texCoord', 0)}")
        image = self.json["images"][self.json["textures"][info["index"]]["source"]]
        return image["name"], info.get("intensity", 1.0)


def trs(translation, quaternion, scale):
    x, y, z, w = np.asarray(quaternion, float) / np.linalg.norm(quaternion)
    matrix = np.eye(4)
    matrix[:3, :3] = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                               [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                               [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]) * np.asarray(scale)
    matrix[:3, 3] = translation
    return matrix


def local_matrix(node):
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    return trs(node.get("translation", [0, 0, 0]), node.get("rotation", [0, 0, 0, 1]), node.get("scale", [1, 1, 1]))


class LitTriangles:
    """World-space triangles that have a lightmap: corners (n, 3, 3), normals, uv (n, 3, 2), page index, page names."""

    def __init__(self, glb):
        corners, uvs, pages, self.page_names = [], [], [], []
        for node, world in glb.world_nodes():
            for primitive in glb.json["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
                lightmap = glb.lightmap_of(primitive.get("material"))
                attributes = primitive["attributes"]
                if lightmap is None or primitive.get("mode", TRIANGLES) != TRIANGLES or "TEXCOORD_1" not in attributes:
                    continue
                position = glb.values(attributes["POSITION"]) @ world[:3, :3].T + world[:3, 3]
                uv = glb.values(attributes["TEXCOORD_1"])
                order = glb.raw(primitive["indices"])[:, 0] if "indices" in primitive else np.arange(len(position))
                order = order.astype(int).reshape(-1, 3)
                if np.linalg.det(world[:3, :3]) < 0:
                    order = order[:, ::-1]
                corners.append(position[order])
                uvs.append(uv[order])
                if lightmap[0] not in self.page_names:
                    self.page_names.append(lightmap[0])
                pages.append(np.full(len(order), self.page_names.index(lightmap[0])))
        if not corners:
            raise ValueError("no triangle has a lightmap")
        self.corners, self.uvs, self.pages = np.concatenate(corners), np.concatenate(uvs), np.concatenate(pages)
        cross = np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0])
        length = np.linalg.norm(cross, axis=1)
        keep = length > 0
        self.corners, self.uvs, self.pages = self.corners[keep], self.uvs[keep], self.pages[keep]
        self.normals = cross[keep] / length[keep, None]
        self.lower, self.upper = self.corners.min(1), self.corners.max(1)

    def find(self, point, normal, reach):
        """(triangle, uv) of the surface nearest to a point, on the side of the normal; None beyond reach."""
        near = ((self.lower <= point + reach) & (point - reach <= self.upper)).all(1)
        near = np.nonzero(near)[0]
        near = near[self.normals[near] @ normal > 0.7]
        best, found = reach, None
        for triangle in near:
            weights = nearest_weights(self.corners[triangle], point)
            distance = np.linalg.norm(weights @ self.corners[triangle] - point)
            if distance < best:
                best, found = distance, (triangle, weights @ self.uvs[triangle])
        return found


def nearest_weights(corners, point):
    """Barycentric weights of the point of a triangle that is nearest to `point`."""
    a, ab, ac = corners[0], corners[1] - corners[0], corners[2] - corners[0]
    d11, d12, d22 = ab @ ab, ab @ ac, ac @ ac
    e1, e2 = ab @ (point - a), ac @ (point - a)
    determinant = d11 * d22 - d12 * d12
    if determinant > 0:
        u, v = (d22 * e1 - d12 * e2) / determinant, (d11 * e2 - d12 * e1) / determinant
        if u >= 0 and v >= 0 and u + v <= 1:
            return np.array([1 - u - v, u, v])
    best, weights = np.inf, None
    for i in range(3):  # on one of the edges
        p, q = corners[i], corners[(i + 1) % 3]
        t = np.clip((point - p) @ (q - p) / max((q - p) @ (q - p), 1e-300), 0, 1)
        distance = np.linalg.norm(p + t * (q - p) - point)
        if distance < best:
            best, weights = distance, np.zeros(3)
            weights[i], weights[(i + 1) % 3] = 1 - t, t
    return weights
