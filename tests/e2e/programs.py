"""Runs the two programs: `lightbatch` and, for those who want one, a daemon of `lightbatchd`."""
import argparse
import json
import os
import signal
import struct
import subprocess
import sys
import tempfile
import unittest

OPTIONS = None


class Daemon:
    """A daemon on free ports of loopback; its log goes to a file."""

    def __init__(self, data, listen="127.0.0.1:0"):
        self.log = data + ".log"
        with open(self.log, "a") as log:
            self.process = subprocess.Popen(
                [OPTIONS.daemon, "--data", data, "--listen", listen, "--admin-port", "0",
                 "--log-format", "json"], stderr=subprocess.PIPE, text=True)
            for line in self.process.stderr:
                log.write(line)
                entry = json.loads(line)
                if entry["event"] == "daemon.ready":
                    self.address = "127.0.0.1:" + entry["port"]
                    self.admin = "127.0.0.1:" + entry["admin_port"]
                    break
            else:
                raise RuntimeError("the daemon did not start; see " + self.log)
        self.drain = subprocess.Popen(["cat"], stdin=self.process.stderr,
                                      stdout=open(self.log, "a"))

    def alive(self):
        return self.process.poll() is None

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(timeout=60)
        self.drain.wait(timeout=10)
        return code


def lightbatch(*words, timeout=900):
    """One run of the command: code, stdout, stderr."""
    return subprocess.run([OPTIONS.client, *map(str, words)], capture_output=True, text=True,
                          timeout=timeout)


class WithFolder(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = self.temporary.name

    def tearDown(self):
        self.temporary.cleanup()

    def path(self, *parts):
        return os.path.join(self.folder, *parts)

    def write(self, name, data):
        with open(self.path(name), "wb") as file:
            file.write(data)
        return self.path(name)


def glb(document, binary=b""):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    if binary:
        binary += b"\0" * (-len(binary) % 4)
        chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def room_document():
    """A room of one metre seen from inside, with a lamp under its ceiling: document and buffer."""
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    positions, indices = [], []
    for quad in quads:
        base = len(positions)
        positions += [corners[i] for i in quad]
        indices += [base, base + 2, base + 1, base, base + 3, base + 2]
    room = len(indices)
    base = len(positions)
    positions += [(0.3, 0.99, 0.3), (0.7, 0.99, 0.3), (0.7, 0.99, 0.7), (0.3, 0.99, 0.7)]
    indices += [base, base + 1, base + 2, base, base + 2, base + 3]
    vertices = b"".join(struct.pack("<3f", *p) for p in positions)
    binary = vertices + struct.pack("<%dH" % len(indices), *indices)
    primitive = lambda accessor, material: {"primitives": [
        {"attributes": {"POSITION": 0}, "indices": accessor, "material": material}]}
    return {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0, "name": "room"}, {"mesh": 1, "name": "lamp"}],
        "materials": [
            {"pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.5, 0.4, 1], "metallicFactor": 0}},
            {"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0},
             "emissiveFactor": [1, 1, 1],
             "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 100}}}],
        "extensionsUsed": ["KHR_materials_emissive_strength"],
        "meshes": [primitive(1, 0), primitive(2, 1)],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(positions), "type": "VEC3",
             "min": [0, 0, 0], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5123, "count": room, "type": "SCALAR"},
            {"bufferView": 1, "byteOffset": room * 2, "componentType": 5123,
             "count": len(indices) - room, "type": "SCALAR"}],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(vertices), "target": 34962},
            {"buffer": 0, "byteOffset": len(vertices), "byteLength": len(binary) - len(vertices),
             "target": 34963}],
        "buffers": [{"byteLength": len(binary)}]}, binary


def room_glb():
    return glb(*room_document())


def run(*cases):
    global OPTIONS
    parser = argparse.ArgumentParser()
    parser.add_argument("--daemon", required=True)
    parser.add_argument("--client", required=True)
    parser.add_argument("--shared", default="")
    OPTIONS, names = parser.parse_known_args()
    loader = unittest.defaultTestLoader
    suite = unittest.TestSuite(
        loader.loadTestsFromNames(names, case) if names else loader.loadTestsFromTestCase(case)
        for case in cases)
    result = unittest.TextTestRunner(verbosity=2).run(suite)
    sys.exit(0 if result.wasSuccessful() else 1)
