#!/usr/bin/env python3
"""Hostile files through one daemon, and through the command alone: each ends with a reason, none kills
a worker, the daemon serves on. The wide set (badinput/ with its expected.tsv) runs where it is
present. Any build will do, the sanitised ones too."""
import csv
import json
import os
import urllib.request

import programs
from programs import lightbatch

QUICK = ["--no-cache", "-q", "--json"]


def mutations(whole):
    """Files of this script's making: cuts, flips, lies."""
    yield "empty.glb", b""
    yield "magic.glb", whole[:4]
    for percent in (1, 10, 50, 90, 99):
        yield "cut_%d.glb" % percent, whole[:len(whole) * percent // 100]
    document, binary = programs.room_document()
    lies = {
        "count": lambda d: d["accessors"][0].update(count=2**31),
        "index": lambda d: d["accessors"][1].update(bufferView=99),
        "cycle": lambda d: d["nodes"][0].update(children=[1]) or d["nodes"][1].update(children=[0]),
        "escape": lambda d: d["buffers"].append({"byteLength": 4, "uri": "../../etc/passwd"}),
        "network": lambda d: d["buffers"][0].update(uri="http://localhost/x"),
        "required": lambda d: d.update(extensionsRequired=["EXT_unheard_of"]),
        "type": lambda d: d.update(nodes="none"),
    }
    for name, lie in lies.items():
        document, binary = programs.room_document()
        lie(document)
        yield "lie_%s.glb" % name, programs.glb(document, binary)
    yield "deep.gltf", b"[" * 100_000


class Files:
    """Each file once; `where` says who plans it."""
    where = []

    def plan(self, file):
        done = lightbatch("plan", file, *QUICK, *self.where, timeout=300)
        result = json.loads(done.stdout) if done.stdout else {}
        return done.returncode, result.get("error", {}).get("reason", ""), done.stderr

    def test_made_up(self):
        for name, data in mutations(programs.room_glb()):
            with self.subTest(name):
                code, reason, text = self.plan(self.write(name, data))
                self.assertEqual(code, 3, text)
                self.assertTrue(reason.startswith(("INPUT_", "SCENE_URI")), reason)

    def test_shared(self):
        root = os.path.join(programs.OPTIONS.shared, "badinput")
        table = os.path.join(root, "expected.tsv")
        rows = list(csv.DictReader(open(table), delimiter="\t")) if os.path.exists(table) else []
        for row in rows:
            with self.subTest(row["file"]):
                code, reason, text = self.plan(os.path.join(root, row["file"]))
                self.assertNotIn(reason, ("WORKER_CRASHED", "WORKER_OOM", "TIMEOUT"), text)
                if row["expect"] in ("reject", "refuse"):
                    self.assertEqual(code, 3, row["reason"] + ": " + text)
                elif row["expect"] == "load":
                    self.assertNotEqual(reason, "INPUT_MALFORMED", row["reason"] + ": " + text)
                else:
                    self.assertIn(code, (0, 3), row["reason"] + ": " + text)


class BadInput(Files, programs.WithFolder):
    """Through one daemon, which still serves after the last of them."""

    def setUp(self):
        super().setUp()
        self.daemon = programs.Daemon(self.path("data"))
        self.where = ["--server", self.daemon.address]

    def tearDown(self):
        self.assertTrue(self.daemon.alive())
        health = urllib.request.urlopen("http://%s/readyz" % self.daemon.admin).read()
        self.assertEqual(health, b"ready\n")
        self.assertEqual(self.daemon.stop(), 0)
        super().tearDown()


class BadInputEmbedded(Files, programs.WithFolder):
    """Through the service inside the command."""


if __name__ == "__main__":
    programs.run(BadInput, BadInputEmbedded)
