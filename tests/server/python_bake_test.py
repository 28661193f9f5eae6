#!/usr/bin/env python3
"""A bake with the real daemon, asked for in another language."""
import hashlib
import json
import struct

import daemon_client as client


def box_scene():
    """A room of one metre seen from inside, with a lamp in its ceiling, as .glb."""
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    positions, indices = [], []
    for quad in quads:
        base = len(positions)
        positions += [corners[i] for i in quad]
        indices += [base, base + 2, base + 1, base, base + 3, base + 2]
    lamp = len(indices)
    base = len(positions)
    positions += [(0.3, 0.99, 0.3), (0.7, 0.99, 0.3), (0.7, 0.99, 0.7), (0.3, 0.99, 0.7)]
    indices += [base, base + 1, base + 2, base, base + 2, base + 3]
    vertex_bytes = b"".join(struct.pack("<3f", *p) for p in positions)
    index_bytes = struct.pack("<%dH" % len(indices), *indices)
    binary = vertex_bytes + index_bytes
    binary += b"\0" * (-len(binary) % 4)
    low, high = [0.0] * 3, [1.0] * 3
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0, "name": "room"}, {"mesh": 1, "name": "lamp"}],
        "materials": [
            {"pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.5, 0.4, 1], "metallicFactor": 0}},
            {"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0},
             "emissiveFactor": [1, 1, 1],
             "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 100}}}],
        "extensionsUsed": ["KHR_materials_emissive_strength"],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]},
            {"primitives": [{"attributes": {"POSITION": 0}, "indices": 2, "material": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(positions), "type": "VEC3",
             "min": low, "max": high},
            {"bufferView": 1, "componentType": 5123, "count": lamp, "type": "SCALAR"},
            {"bufferView": 1, "byteOffset": lamp * 2, "componentType": 5123,
             "count": len(indices) - lamp, "type": "SCALAR"}],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(vertex_bytes), "target": 34962},
            {"buffer": 0, "byteOffset": len(vertex_bytes), "byteLength": len(index_bytes),
             "target": 34963}],
        "buffers": [{"byteLength": len(binary)}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    return (struct.pack("<III", 0x46546c67, 2, 28 + len(text) + len(binary)) +
            struct.pack("<II", len(text), 0x4e4f534a) + text +
            struct.pack("<II", len(binary), 0x004e4942) + binary)


class Bake(client.WithDaemon):
    def bake(self, **options):
        scene = client.make_scene(self.daemon, box_scene(), "room.glb")
        job = self.daemon.jobs.SubmitJob(client.STUBS.job_service.SubmitJobRequest(
            scene=scene.name, cache_policy=client.STUBS.job_service.CACHE_POLICY_OFF,
            options=client.STUBS.job_options.JobOptions(
                target_error=0.05, texels_per_metre=16, lightmap_size=256, **options)))
        return client.watch_to_end(self.daemon, job.name)

    def test_bake(self):
        job = self.bake()
        self.assertEqual(job.state, client.STUBS.job_service.JOB_STATE_SUCCEEDED, job.error)
        artifacts = {a.path: a.digest for a in job.artifacts}
        for path in ["scene.glb", "lightmap_0.exr", "report.json", "report.html"]:
            self.assertIn(path, artifacts)
        scene = client.read_blob(self.daemon, artifacts["scene.glb"])
        self.assertEqual(scene[:4], b"glTF")
        self.assertEqual(hashlib.sha256(scene).hexdigest(), artifacts["scene.glb"].sha256)
        json.loads(client.read_blob(self.daemon, artifacts["report.json"]))
        again = {a.path: a.digest for a in self.bake(threads=1).artifacts}
        for path in ["scene.glb", "lightmap_0.exr"]:
            self.assertEqual(again[path].sha256, artifacts[path].sha256, path)

    def test_bad_scene_is_refused_and_the_daemon_serves_on(self):
        scene = client.make_scene(self.daemon, box_scene()[:200], "room.glb")
        job = self.daemon.jobs.SubmitJob(
            client.STUBS.job_service.SubmitJobRequest(scene=scene.name))
        failed = client.watch_to_end(self.daemon, job.name)
        self.assertEqual(failed.state, client.STUBS.job_service.JOB_STATE_FAILED)
        self.assertEqual(failed.error.detail.reason, "INPUT_MALFORMED")
        self.assertIn("room.glb", failed.error.detail.place)


if __name__ == "__main__":
    client.run(Bake)
