#!/usr/bin/python3
"""What batches cost: CPU seconds of a bake without lightmaps beside gltf-transform's join and gltfpack, and its peak memory
beside what the scene takes once it is decoded.

  cost.py --modules NODE_MODULES [--scenes DIR] [--out DIR] [--lightbatch FILE] [--runs N] [--against NAME=RATIO...] [SCENE...]

NODE_MODULES: a folder with @gltf-transform/cli. gltfpack is taken from PATH. CPU seconds (user and system, all processes) are
medians of N runs, the programs by turns. Where join writes without the input's compression, it is held against a bake that
does so, too (plain CPU s). Decoded: bytes of positions, normals, tangents, texture coordinates and colours
as floats, indices of 4 bytes, each mesh once for each placement, and images in 8-bit RGBA. Peak: of the largest process,
less what it takes for a scene of one triangle. Exit code 0: no more CPU than join on any scene, no more than RATIO times
gltfpack's on the scenes NAMEd, and no more memory than 6 times the decoded bytes (or 16 MiB: threads have stacks).
"""
import argparse
import json
import os
import pathlib
import shutil
import statistics
import struct
import subprocess
import sys

import table

BYTES = {"POSITION": 12, "NORMAL": 12, "TANGENT": 16, "TEXCOORD": 8, "COLOR": 16}
LARGEST_MEMORY, LITTLE_MEMORY = 6, 16 * 2**20


def image_size(data):
    """Width and height of a PNG, JPEG, WebP or KTX2; (0, 0) of anything else."""
    if data[:8] == b"\x89PNG\r\n\x1a\n":
        return struct.unpack_from(">II", data, 16)
    if data[:12] == b"\xabKTX 20\xbb\r\n\x1a\n":
        return struct.unpack_from("<II", data, 20)
    if data[:4] == b"RIFF" and data[12:16] == b"VP8X":
        return tuple(1 + int.from_bytes(data[at:at + 3], "little") for at in (24, 27))
    if data[:4] == b"RIFF" and data[12:16] == b"VP8L":
        bits = int.from_bytes(data[21:25], "little")
        return 1 + (bits & 0x3fff), 1 + (bits >> 14 & 0x3fff)
    if data[:4] == b"RIFF" and data[12:16] == b"VP8 ":
        return tuple(size & 0x3fff for size in struct.unpack_from("<HH", data, 26))
    at = 2
    while data[:2] == b"\xff\xd8" and at + 9 < len(data):
        marker, size = struct.unpack_from(">xBH", data, at)
        if 0xc0 <= marker <= 0xcf and marker not in (0xc4, 0xc8, 0xcc):
            return struct.unpack_from(">HH", data, at + 5)[::-1]
        at += 2 + size
    return 0, 0


def placements(document):
    """How often each mesh is drawn."""
    times = [0] * len(document.get("meshes", []))
    for node in document.get("nodes", []):
        if "mesh" in node:
            attributes = node.get("extensions", {}).get("EXT_mesh_gpu_instancing", {}).get("attributes", {})
            times[node["mesh"]] += document["accessors"][next(iter(attributes.values()))]["count"] if attributes else 1
    return times


def decoded_bytes(path):
    """Of a .glb whose images are inside."""
    data = path.read_bytes()
    size = struct.unpack_from("<I", data, 12)[0]
    document, binary = json.loads(data[20:20 + size]), data[20 + size + 8:]
    total = 0
    for mesh, times in zip(document.get("meshes", []), placements(document)):
        for primitive in mesh["primitives"]:
            bytes_of_vertex = sum(BYTES.get(name.split("_")[0], 0) for name in primitive["attributes"])
            vertices = document["accessors"][primitive["attributes"]["POSITION"]]["count"]
            indices = document["accessors"][primitive["indices"]]["count"] if "indices" in primitive else vertices
            total += times * (vertices * bytes_of_vertex + 4 * indices)
    for image in document.get("images", []):
        if "bufferView" in image:
            view = document["bufferViews"][image["bufferView"]]
            start = view.get("byteOffset", 0)
            width, height = image_size(binary[start:start + view["byteLength"]])
            total += 4 * width * height
    return total


def cpu_of(words):
    """CPU seconds of a program and all below it; None where it refuses."""
    process = subprocess.Popen([str(w) for w in words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                               stdin=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    return used.ru_utime + used.ru_stime if status == 0 else None


def is_compressed(path):
    """Whether meshes of a .glb need a decoder. Reads no more than it must: children start as large as this process is."""
    with path.open("rb") as file:
        header = file.read(20)
        required = json.loads(file.read(struct.unpack_from("<I", header, 12)[0])).get("extensionsRequired", [])
    return any(name in required for name in ("KHR_draco_mesh_compression", "EXT_meshopt_compression"))


def one_triangle(path):
    """Writes the smallest scene."""
    binary = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0) + b"\0" * 4
    text = json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "buffers": [{"byteLength": len(binary)}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
    }).encode()
    text += b" " * (-len(text) % 4)
    path.write_bytes(struct.pack("<5I", 0x46546C67, 2, 28 + len(text) + len(binary), len(text), 0x4E4F534A) + text +
                     struct.pack("<2I", len(binary), 0x004E4942) + binary)


def measure(words, scene):
    """Medians of CPU seconds (ours; plain, where join's output is; join's; gltfpack's) and our peak bytes."""
    ours, plain, join, pack, peaks = [], [], [], [], []
    out = words.out / scene.stem
    for _ in range(words.runs):
        shutil.rmtree(out, ignore_errors=True)
        code, _, cpu, peak = table.bake(words.lightbatch, scene, out, ["--no-lightmaps", "--quiet"])
        if code != 0:
            sys.exit(f"{scene}: exit code {code}; see {out}.log")
        ours.append(cpu)
        peaks.append(peak)
        joined = words.out / "join.glb"
        join.append(cpu_of([words.modules / ".bin/gltf-transform", "join", scene, joined]))
        if join[-1] is not None and is_compressed(scene) and not is_compressed(joined):
            shutil.rmtree(out)
            plain.append(table.bake(words.lightbatch, scene, out, ["--no-lightmaps", "--quiet", "--compress", "none"])[2])
        if shutil.which("gltfpack"):
            pack.append(cpu_of(["gltfpack", "-i", scene, "-o", words.out / "pack.glb"]))
    median = lambda times: statistics.median(times) if times and None not in times else None
    return median(ours), median(plain), median(join), median(pack), statistics.median(peaks)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--modules", type=pathlib.Path, required=True)
    parser.add_argument("--scenes", type=pathlib.Path, default=table.ROOT / "tests/data/scenes")
    parser.add_argument("--out", type=pathlib.Path, default=table.ROOT / "build/cost")
    parser.add_argument("--lightbatch", type=pathlib.Path, default=table.ROOT / "build/release/client/cli/lightbatch")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--against", action="append", default=[], metavar="NAME=RATIO")
    parser.add_argument("names", nargs="*", metavar="SCENE")
    words = parser.parse_args()
    words.out.mkdir(parents=True, exist_ok=True)
    limits = dict(word.split("=") for word in words.against)
    one_triangle(words.out / "triangle.glb")
    least = table.bake(words.lightbatch, words.out / "triangle.glb", words.out / "triangle", ["--no-lightmaps", "--quiet"])[3]
    print(f"a scene of one triangle: {least / 2**20:.1f} MiB\n")
    print("| scene | CPU s | plain | join | / join | gltfpack | / gltfpack | decoded MiB | peak MiB | / decoded | |\n|" + " --- |" * 11)
    failed = 0
    for name in words.names or sorted(path.stem for path in words.scenes.glob("*.glb")):
        scene = words.scenes / f"{name}.glb"
        ours, plain, join, pack, peak = measure(words, scene)
        alike = ours if plain is None else plain
        decoded = decoded_bytes(scene)
        own = max(0, peak - least)
        short = []
        if join is not None and alike > join:
            short.append("dearer than join")
        if name in limits and (pack is None or ours > float(limits[name]) * pack):
            short.append(f"more than {limits[name]} times gltfpack")
        if own > max(LARGEST_MEMORY * decoded, LITTLE_MEMORY):
            short.append(f"more than {LARGEST_MEMORY} times the memory")
        failed += bool(short)
        ratio = lambda own, other: "refused | -" if other is None else f"{other:.2f} | {own / other:.2f}"
        print(f"| {name} | {ours:.2f} | {'-' if plain is None else f'{plain:.2f}'} | {ratio(alike, join)} | {ratio(ours, pack)} | {decoded / 2**20:.2f} | {peak / 2**20:.1f} | "
              f"{own / decoded:.2f} | {', '.join(short) or 'ok'} |", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
