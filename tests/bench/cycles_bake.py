"""Bakes diffuse irradiance with Blender's Cycles into the lightmap coordinates of a file that lightbatch baked. Blender runs it:

  blender -b -noaudio --factory-startup --python-exit-code 1 --python cycles_bake.py -- BAKED.glb SOURCE.glb OUT [options]

Geometry, materials and coordinates come from BAKED.glb (which must keep one material a lightmap page), lights from SOURCE.glb.
The scene is built here from the glTF data itself, not by Blender's importer, which changes units, lights and sides. Sample
counts rise fourfold until the CPU budget is spent; OUT_N.npz holds the pages of the bake with N samples (lux, row 0 is v = 0,
NaN where Cycles bakes nothing). Prints one line `cycles: {...}` a bake; only the bake itself is timed.

Units: glTF's numbers are taken as radiometric ones. Cycles' DIFFUSE pass without colour is irradiance / pi; a point lamp of
P watts has P / (4 pi) W/sr. Faces are flat, as lightbatch lights them; single-sided ones reflect and emit to their front only.
"""
import argparse
import json
import math
import os
import pathlib
import resource
import sys
import tempfile
import time

import bpy
import numpy as np
from mathutils import Matrix, Vector

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "peers"))
import gltf_file  # noqa: E402

EMPTY = -1.0
LEAST_ALBEDO = 1e-3  # Cycles divides by the colour: a channel of 0 would bake as 0
MOST_BOUNCES = 64


def to_blender(v):
    """glTF's y up to Blender's z up."""
    v = np.asarray(v)
    return np.stack([v[..., 0], -v[..., 2], v[..., 1]], -1)


def refuse(what):
    sys.exit(f"cycles_bake.py: {what} is not translated for Cycles")


class Materials:
    """A Blender material for each material of the file, with the page that it bakes into."""

    def __init__(self, glb, pages):
        self.glb, self.pages, self.images, self.made = glb, pages, {}, {}

    def image(self, slot):
        info = self.glb.json["textures"][slot["index"]]
        if slot.get("texCoord", 0) != 0 or slot.get("extensions"):
            refuse("a texture with its own coordinates")
        source = info.get("source")
        if source not in self.images:
            view = self.glb.json["bufferViews"][self.glb.json["images"][source]["bufferView"]]
            start = view.get("byteOffset", 0)
            with tempfile.NamedTemporaryFile() as file:
                file.write(self.glb.binary[start:start + view["byteLength"]])
                file.flush()
                image = self.images[source] = bpy.data.images.load(file.name)
                image.alpha_mode = "CHANNEL_PACKED"
                image.pack()  # Cycles reads it when it bakes
        return self.images[source]

    def of(self, index):
        if index not in self.made:
            self.made[index] = self.make(self.glb.json["materials"][index] if index is not None else {}, index)
        return self.made[index]

    def make(self, info, index):
        material = bpy.data.materials.new(info.get("name", "default"))
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        new, link = tree.nodes.new, tree.links.new
        pbr = info.get("pbrMetallicRoughness", {})
        known = {"KHR_materials_emissive_strength", "MOZ_lightmap", "KHR_materials_specular", "KHR_materials_ior"}
        if set(info.get("extensions", {})) - known:
            refuse(f"material extension {sorted(set(info['extensions']) - known)}")
        if "metallicRoughnessTexture" in pbr or "emissiveTexture" in info:
            refuse("a metallic or emissive texture")

        def scaled(color, factor):
            node = new("ShaderNodeVectorMath")
            node.operation = "MULTIPLY"
            link(color, node.inputs[0])
            if hasattr(factor, "links"):
                link(factor, node.inputs[1])
            else:
                node.inputs[1].default_value = factor
            return node.outputs[0]

        def constant(rgb):
            node = new("ShaderNodeCombineXYZ")
            for socket, value in zip(node.inputs, rgb):
                socket.default_value = value
            return node.outputs[0]

        factor = pbr.get("baseColorFactor", [1, 1, 1, 1])
        matte = 1 - pbr.get("metallicFactor", 1)
        color, alpha = constant([f * matte for f in factor[:3]]), None
        if "baseColorTexture" in pbr:
            texture = new("ShaderNodeTexImage")
            texture.image = self.image(pbr["baseColorTexture"])
            coordinates = new("ShaderNodeUVMap")
            coordinates.uv_map = "colour"
            link(coordinates.outputs[0], texture.inputs[0])
            color, alpha = scaled(texture.outputs["Color"], [f * matte for f in factor[:3]]), texture.outputs["Alpha"]
        least = new("ShaderNodeVectorMath")
        least.operation = "MAXIMUM"
        link(color, least.inputs[0])
        least.inputs[1].default_value = (LEAST_ALBEDO,) * 3
        color = least.outputs[0]
        front = None
        if not info.get("doubleSided"):
            facing = new("ShaderNodeNewGeometry")
            inverse = new("ShaderNodeMath")
            inverse.operation = "SUBTRACT"
            inverse.inputs[0].default_value = 1
            link(facing.outputs["Backfacing"], inverse.inputs[1])
            front = inverse.outputs[0]
            color = scaled(color, front)
        diffuse = new("ShaderNodeBsdfDiffuse")
        link(color, diffuse.inputs["Color"])
        shader = diffuse.outputs[0]
        strength = info.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1)
        if max(info.get("emissiveFactor", [0])) > 0:
            emission = new("ShaderNodeEmission")
            emission.inputs["Color"].default_value = (*info["emissiveFactor"], 1)
            emission.inputs["Strength"].default_value = strength
            if front is not None:
                times = new("ShaderNodeMath")
                times.operation = "MULTIPLY"
                times.inputs[1].default_value = strength
                link(front, times.inputs[0])
                link(times.outputs[0], emission.inputs["Strength"])
            both = new("ShaderNodeAddShader")
            link(shader, both.inputs[0])
            link(emission.outputs[0], both.inputs[1])
            shader = both.outputs[0]
        mode = info.get("alphaMode", "OPAQUE")
        if mode != "OPAQUE" and (alpha is not None or factor[3] < 1):
            cover = new("ShaderNodeMath")
            cover.operation = "MULTIPLY"
            cover.inputs[0].default_value, cover.inputs[1].default_value = 1, factor[3]
            if alpha is not None:
                link(alpha, cover.inputs[0])
            if mode == "MASK":
                above = new("ShaderNodeMath")
                above.operation = "GREATER_THAN"
                above.inputs[1].default_value = info.get("alphaCutoff", 0.5)
                link(cover.outputs[0], above.inputs[0])
                cover = above
            mix = new("ShaderNodeMixShader")
            link(cover.outputs[0], mix.inputs[0])
            link(new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[1])
            link(shader, mix.inputs[2])
            shader = mix.outputs[0]
        link(shader, new("ShaderNodeOutputMaterial").inputs["Surface"])
        lightmap = self.glb.lightmap_of(index)
        if lightmap is not None:
            target = new("ShaderNodeTexImage")
            target.image = self.pages[lightmap[0]]
            tree.nodes.active = target
        return material


def page_images(glb):
    """A float image for each page, of the size that lightbatch gave it."""
    pages = {}
    for material in range(len(glb.json.get("materials", []))):
        lightmap = glb.lightmap_of(material)
        if lightmap is None or lightmap[0] in pages:
            continue
        info = next(i for i in glb.json["images"] if i.get("name") == lightmap[0])
        view = glb.json["bufferViews"][info["bufferView"]]
        start = view.get("byteOffset", 0)
        width, height = np.frombuffer(glb.binary[start + 16:start + 24], ">u4")  # PNG's IHDR
        pages[lightmap[0]] = bpy.data.images.new(lightmap[0], int(width), int(height), alpha=True, float_buffer=True,
                                                 is_data=True)
    return pages


def add_mesh(glb, materials):
    """All triangles of the file as one object."""
    corners, colour, light, slots, order = [], [], [], [], {}
    for node, world in glb.world_nodes():
        for primitive in glb.json["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
            if primitive.get("mode", gltf_file.TRIANGLES) != gltf_file.TRIANGLES:
                continue
            attributes = primitive["attributes"]
            if "COLOR_0" in attributes:
                refuse("COLOR_0")
            position = glb.values(attributes["POSITION"]) @ world[:3, :3].T + world[:3, 3]
            indices = glb.raw(primitive["indices"])[:, 0] if "indices" in primitive else np.arange(len(position))
            indices = indices.astype(int).reshape(-1, 3)
            if np.linalg.det(world[:3, :3]) < 0:
                indices = indices[:, ::-1]
            corners.append(to_blender(position[indices]))
            for name, into in (("TEXCOORD_0", colour), ("TEXCOORD_1", light)):
                uv = glb.values(attributes[name]) if name in attributes else np.zeros((len(position), 2))
                into.append(np.stack([uv[:, 0], 1 - uv[:, 1]], -1)[indices])
            slot = order.setdefault(primitive.get("material"), len(order))
            slots.append(np.full(len(indices), slot, np.int32))
    corners = np.concatenate(corners).astype(np.float32)
    count = len(corners)
    mesh = bpy.data.meshes.new("scene")
    mesh.vertices.add(3 * count)
    mesh.vertices.foreach_set("co", corners.ravel())
    mesh.loops.add(3 * count)
    mesh.loops.foreach_set("vertex_index", np.arange(3 * count, dtype=np.int32))
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(count, 3, np.int32))
    for name, uv in (("colour", colour), ("light", light)):
        mesh.uv_layers.new(name=name).data.foreach_set("uv", np.concatenate(uv).astype(np.float32).ravel())
    for index in order:
        mesh.materials.append(materials.of(index))
    mesh.polygons.foreach_set("material_index", np.concatenate(slots))
    mesh.update(calc_edges=True)
    mesh.uv_layers.active = mesh.uv_layers["light"]
    scene_object = bpy.data.objects.new("scene", mesh)
    bpy.context.scene.collection.objects.link(scene_object)
    return scene_object


def add_lights(glb):
    definitions = glb.json.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
    for node, world in glb.world_nodes():
        which = node.get("extensions", {}).get("KHR_lights_punctual", {}).get("light")
        if which is None:
            continue
        info = definitions[which]
        if "range" in info or info["type"] == "spot":
            refuse("a spot light or a light with a range")
        sun = info["type"] == "directional"
        light = bpy.data.lights.new("light", "SUN" if sun else "POINT")
        light.color = info.get("color", [1, 1, 1])
        light.energy = info.get("intensity", 1) * (1 if sun else 4 * math.pi)
        if sun:
            light.angle = 0
        else:
            light.shadow_soft_size = 0
        placed = bpy.data.objects.new("light", light)
        bpy.context.scene.collection.objects.link(placed)
        backwards = Vector(to_blender(world[:3, 2])).normalized()  # lights shine along -z of their node
        placed.matrix_world = Matrix.Translation(to_blender(world[:3, 3])) @ backwards.to_track_quat("Z", "Y").to_matrix().to_4x4()


def set_up(words):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.threads_mode, scene.render.threads = "FIXED", words.threads
    cycles = scene.cycles
    cycles.device, cycles.seed, cycles.use_denoising, cycles.use_adaptive_sampling = "CPU", words.seed, False, False
    cycles.max_bounces = cycles.diffuse_bounces = MOST_BOUNCES
    cycles.transparent_max_bounces = MOST_BOUNCES
    cycles.glossy_bounces = cycles.transmission_bounces = 0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.light_sampling_threshold = 0
    cycles.use_fast_gi = False
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (words.sky, words.sky, words.sky, 1)
    background.inputs["Strength"].default_value = 1
    scene.render.bake.margin = 0
    scene.render.bake.use_clear = False


def bake(pages):
    """Seconds of wall time and of CPU, and the pages in lux."""
    for image in pages.values():
        image.pixels.foreach_set(np.full(4 * image.size[0] * image.size[1], EMPTY, np.float32))
        image.update()
    wall, cpu = time.perf_counter(), time.process_time()
    bpy.ops.object.bake(type="DIFFUSE", pass_filter={"DIRECT", "INDIRECT"}, margin=0, use_clear=False, target="IMAGE_TEXTURES")
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    lux = {}
    for name, image in pages.items():
        values = np.empty(4 * image.size[0] * image.size[1], np.float32)
        image.pixels.foreach_get(values)
        values = values.reshape(image.size[1], image.size[0], 4)[::-1, :, :3]
        lux[name] = np.where(values[..., :1] > EMPTY / 2, values * math.pi, np.nan).astype(np.float32)
    return wall, cpu, lux


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("baked")
    parser.add_argument("source")
    parser.add_argument("out")
    parser.add_argument("--sky", type=float, default=0, help="nits")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=4, help="samples of the first bake")
    parser.add_argument("--budget", type=float, default=60, help="CPU seconds after which no further bake begins")
    words = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    baked = gltf_file.Glb(words.baked)
    pages = page_images(baked)
    scene_object = add_mesh(baked, Materials(baked, pages))
    add_lights(gltf_file.Glb(words.source))
    set_up(words)
    bpy.context.view_layer.objects.active = scene_object
    scene_object.select_set(True)
    samples, spent = words.first, 0.0
    while True:
        bpy.context.scene.cycles.samples = samples
        wall, cpu, lux = bake(pages)
        np.savez(f"{words.out}_{samples}.npz", **lux)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
        print("cycles: " + json.dumps({"samples": samples, "seconds": wall, "cpu_seconds": cpu, "peak_bytes": peak,
                                       "file": os.path.abspath(f"{words.out}_{samples}.npz")}), flush=True)
        spent += cpu
        if spent + 4 * cpu > words.budget and spent > cpu * 1.01:
            break
        samples *= 4


main()
