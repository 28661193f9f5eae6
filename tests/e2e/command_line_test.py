#!/usr/bin/env python3
"""`lightbatch` as scripts and people use it: files, exit codes, the same bytes with and without a
daemon and on any number of threads."""
import hashlib
import json
import os
import pathlib
import signal
import subprocess
import sys
import time

import numpy as np

import programs
from programs import lightbatch

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "peers"))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "truth"))
import hdr_file  # noqa: E402
import structure  # noqa: E402

SMALL = ["--texels-per-metre", "16", "--lightmap-size", "256", "--target-error", "10%"]


def digests(folder):
    """What must not change: everything but the reports, which hold times."""
    found = {}
    for name in sorted(os.listdir(folder)):
        if not name.startswith("report."):
            with open(os.path.join(folder, name), "rb") as file:
                found[name] = hashlib.sha256(file.read()).hexdigest()
    return found


class CommandLine(programs.WithFolder):
    def test_bake_without_a_daemon(self):
        scene = self.write("room.glb", programs.room_glb())
        out = self.path("out")
        done = lightbatch("bake", scene, "-o", out, *SMALL, "--json",
                          "--report", self.path("copy.json"))
        self.assertIn(done.returncode, (0, 4), done.stderr)
        result = json.loads(done.stdout)
        self.assertEqual(result["state"], "SUCCEEDED")
        self.assertEqual({a["path"] for a in result["artifacts"]}, set(os.listdir(out)))
        for name in ["scene.glb", "lightmap_0.exr", "report.json", "report.html"]:
            self.assertIn(name, os.listdir(out))
        with open(self.path("copy.json")) as file:
            self.assertEqual(json.load(file)["kind"], "bake")
        self.assertFalse([name for name in os.listdir(out) if "partial" in name])

    def test_same_bytes_everywhere(self):
        scene = self.write("room.glb", programs.room_glb())
        daemon = programs.Daemon(self.path("data"))
        runs = {"one": ["--threads", "1"], "two": ["--threads", "2"],
                "daemon": ["--server", daemon.address],
                "again": ["--server", daemon.address, "--no-cache"]}
        for name, words in runs.items():
            done = lightbatch("bake", scene, "-o", self.path(name), *SMALL, "-q", *words)
            self.assertIn(done.returncode, (0, 4), done.stderr)
        first = digests(self.path("one"))
        for name in runs:
            self.assertEqual(digests(self.path(name)), first, name)
        self.assertEqual(daemon.stop(), 0)

    def test_a_sun_in_the_sky_picture_is_told(self):
        scene = pathlib.Path(__file__).resolve().parent.parent / "data" / "reference" / "open_sky.glb"
        for name, sun in (("grey", 1000), ("sunny", 1e8)):
            sky = np.full((32, 64, 3), 1000.0)
            sky[5, 20] = sun
            hdr_file.write(self.path(name + ".hdr"), sky)
            plan = lightbatch("plan", scene, "-q", "--json", "--sky", self.path(name + ".hdr"))
            self.assertEqual(plan.returncode, 0, plan.stderr)
            effects = {e["name"]: e for e in json.loads(plan.stdout)["report"]["plan"]["effects"]}
            suns = [e for e in effects["sky"]["evidence"] if e.startswith("a sun of")]
            self.assertEqual(len(suns), 1 if name == "sunny" else 0, name)

    def test_other_commands(self):
        scene = self.write("room.glb", programs.room_glb())
        plan = lightbatch("plan", scene, "-q", "--json")
        self.assertEqual(plan.returncode, 0, plan.stderr)
        effects = {e["name"]: e for e in json.loads(plan.stdout)["report"]["plan"]["effects"]}
        for name in ["emitters", "interreflection", "shadows"]:
            self.assertTrue(effects[name]["on"] and 0 < effects[name]["cost_share"] <= 1, name)
        self.assertEqual((effects["sky"]["on"], effects["sky"]["cost_share"]), (False, 0))
        quote = lightbatch("quote", scene, "-q", "--json", "--texels-per-metre", "16")
        self.assertEqual(quote.returncode, 0, quote.stderr)
        result = json.loads(quote.stdout)
        self.assertEqual(result["state"], "SUCCEEDED")
        self.assertEqual(result["report"]["lightmaps"]["texels_per_metre_asked"], 16)
        self.assertGreater(result["report"]["lightmaps"]["texels"], 6 * 16 * 16)
        for name in ["boxes.glb", "boxes.svg", "boxes.png"]:
            drawn = lightbatch("hierarchy", scene, "--levels", "0,1,2", "-o", self.path(name))
            self.assertEqual(drawn.returncode, 0, drawn.stderr)
            for file in drawn.stdout.split("\n"):
                if file.startswith(self.folder):
                    self.assertGreater(os.path.getsize(file), 0)
        compared = lightbatch("hierarchy", scene, "--compare", "-q", "-o", self.path("compared"))
        self.assertEqual(compared.returncode, 0, compared.stderr)
        with open(self.path("compared/hierarchy.json")) as file:
            hierarchy = json.load(file)["hierarchy"]
        rows = hierarchy["compare"]
        self.assertEqual(hierarchy["grids"]["taken"], [])  # too few triangles
        self.assertEqual(len(rows), 7)
        self.assertEqual(len({row["builder"] for row in rows}), 7)
        for row in rows:
            self.assertGreater(row["sah_cost"], 0)
            self.assertGreater(row["links"], 0)
            self.assertGreater(row["grid_rays_per_second"], 0)
        office = lightbatch("scene", "office", "--triangles", "2000", "-o", self.path("office.glb"))
        self.assertEqual(office.returncode, 0, office.stderr)
        self.assertGreater(os.path.getsize(self.path("office.glb")), 10_000)

    def test_views_of_several_files(self):
        office = self.path("office.glb")
        lightbatch("scene", "office", "--triangles", "20000", "-o", office)
        done = lightbatch("bake", office, "-o", self.path("out"), "--no-lightmaps", "-q",
                          "--compress", "meshopt", "--max-growth", "4")
        self.assertEqual(done.returncode, 0, done.stderr)
        baked = self.path("out", "scene.glb")
        with open(self.path("out", "report.json")) as file:
            self.assertEqual(json.load(file)["options"]["compression"], "meshopt")
        document, binary = programs.room_document()
        document["buffers"][0]["uri"] = "room.bin"
        self.write("room.bin", binary)
        room = self.write("room.gltf", json.dumps(document).encode())
        shown = lightbatch("views", office, baked, room, "-q", "--json")
        self.assertEqual(shown.returncode, 0, shown.stderr)
        report = json.loads(shown.stdout)["report"]
        self.assertEqual([f["file"] for f in report["files"]],
                         ["office.glb", "1/scene.glb", "2/room.gltf"])
        before, after = report["files"][0], report["files"][1]
        self.assertEqual(before["all_triangles"], after["all_triangles"])
        self.assertLess(after["all_draws"], before["all_draws"])
        self.assertLess(after["inside"]["cost_us"], before["inside"]["cost_us"])
        for file in (before, after):
            self.assertGreaterEqual(file["inside"]["of_ideal"], 1)
        table = lightbatch("views", office, "-q")
        self.assertIn("office.glb", table.stdout)
        self.assertEqual(lightbatch("views", office, self.path("none.glb"), "-q").returncode, 2)

    def test_vertices_of_16_bits_on_request(self):
        document, binary = programs.room_document()
        scene = self.write("room.glb", programs.glb(document, binary))
        sizes = {}
        for words in ([], ["--quantize", "all"], ["--quantize", "none"]):
            done = lightbatch("bake", scene, "-o", self.path("out"), "--no-lightmaps", *words)
            self.assertEqual(done.returncode, 0, done.stderr)
            with open(self.path("out", "report.json")) as file:
                report = json.load(file)
            name = words[-1] if words else "as input"
            self.assertEqual(report["options"]["quantization"], name)
            self.assertEqual("quantized" in report, name == "all")
            sizes[name] = os.path.getsize(self.path("out", "scene.glb"))
            if name == "all":
                self.assertLess(report["quantized"]["position_error_metres"], 1e-3)
        self.assertEqual(sizes["none"], sizes["as input"])
        both = lightbatch("bake", scene, "-o", self.path("out"), "--no-lightmaps",
                          "--quantize", "all", "--compress", "draco")
        self.assertEqual(both.returncode, 2, both.stderr)

    def test_a_compression_that_holds_nothing_is_told(self):
        document, binary = programs.room_document()
        self.write("room.glb", programs.glb(document, binary))
        for mesh in document["meshes"]:
            for primitive in mesh["primitives"]:
                primitive["mode"] = 0
        self.write("points.glb", programs.glb(document, binary))
        for scene, told in (("room.glb", False), ("points.glb", True)):
            done = lightbatch("bake", self.path(scene), "-o", self.path("out"), "--no-lightmaps",
                              "--compress", "draco")
            self.assertEqual(done.returncode, 0, done.stderr)
            with open(self.path("out", "report.json")) as file:
                warnings = json.load(file)["warnings"]
            self.assertEqual(any("nothing is compressed" in w for w in warnings), told, warnings)

    def test_lines_and_points_are_told(self):
        document, binary = programs.room_document()
        document["meshes"][1]["primitives"][0]["mode"] = 0
        scene = self.write("room.glb", programs.glb(document, binary))
        table = lightbatch("views", scene, "-q")
        self.assertEqual(table.returncode, 0, table.stderr)
        self.assertIn("room.glb: 1 more draws are not counted", table.stdout)
        done = lightbatch("bake", scene, "-o", self.path("out"), "--no-lightmaps", "-q")
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(self.path("out", "report.json")) as file:
            left = json.load(file)["batches"]["left_alone"]
        self.assertIn({"name": "lamp", "reason": "POINTS"}, left)

    def test_cameras(self):
        office = self.path("office.glb")
        lightbatch("scene", "office", "--triangles", "20000", "-o", office)
        cameras = self.write("cameras.json", b'[{"eye": [1, 1.6, 1], "target": [5, 1.5, 1]}]')
        costs = []
        for name, options in (("all", []), ("one", ["--cameras", cameras])):
            done = lightbatch("bake", office, "-o", self.path(name), "--no-lightmaps", "-q", "--draws-share", "1",
                              *options)
            self.assertEqual(done.returncode, 0, done.stderr)
            shown = lightbatch("views", office, self.path(name, "scene.glb"), "--cameras", cameras, "-q", "--json")
            self.assertEqual(shown.returncode, 0, shown.stderr)
            report = json.loads(shown.stdout)["report"]
            self.assertEqual(report["views"], {"inside": 1, "outside": 0})
            costs.append(report["files"][1]["inside"]["cost_us"])
        self.assertLess(costs[1], costs[0])
        with open(self.path("one/report.json")) as file:
            report = json.load(file)
        self.assertEqual(report["batches"]["views"], 1)
        self.assertTrue(report["options"]["cameras_file"].endswith("cameras.json"))
        bad = self.write("bad.json", b'[{"eye": [1, 1.6, 1]}]')
        refused = lightbatch("bake", office, "-o", self.path("bad"), "--no-lightmaps", "-q", "--cameras", bad)
        self.assertEqual(refused.returncode, 3)
        self.assertIn("#/0/target", refused.stderr)

    def test_visible_sets(self):
        office = self.path("office.glb")
        lightbatch("scene", "office", "--triangles", "20000", "-o", office)
        done = lightbatch("bake", office, "-o", self.path("out"), "--no-lightmaps", "--pvs", "-q")
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(self.path("out/pvs.json")) as file:
            sets = json.load(file)
        with open(self.path("out/report.json")) as file:
            summary = json.load(file)["pvs"]
        names = {node.get("name") for node in structure.File(self.path("out/scene.glb")).list("nodes")}
        self.assertLessEqual(set(sets["nodes"]), names)
        self.assertEqual(len(sets["cells"]), summary["cells"])
        self.assertGreater(summary["cells"], 10)
        for cell in sets["cells"]:
            self.assertTrue(all(low < high for low, high in zip(cell["box"][:3], cell["box"][3:])))
            self.assertLess(max(cell["visible"]), len(sets["nodes"]))
        self.assertLess(summary["mean_visible_share"], 0.95)
        self.assertLess(sets["missed_rays"], 1e-3 * sets["checked_rays"])
        refused = lightbatch("bake", office, "-o", self.path("no"), "--no-batches", "--pvs", "-q")
        self.assertEqual(refused.returncode, 2)

    def test_a_gltf_with_its_files(self):
        document, binary = programs.room_document()
        document["buffers"][0]["uri"] = "data/the%20room.bin"
        os.mkdir(self.path("data"))
        self.write("data/the room.bin", binary)
        scene = self.write("room.gltf", json.dumps(document).encode())
        done = lightbatch("plan", scene, "-q")
        self.assertEqual(done.returncode, 0, done.stderr)
        os.remove(self.path("data/the room.bin"))
        refused = lightbatch("plan", scene, "-q")
        self.assertEqual(refused.returncode, 3, refused.stderr)
        self.assertIn("/buffers/0", refused.stderr)

    def test_exit_codes(self):
        scene = self.write("room.glb", programs.room_glb())
        broken = self.write("broken.glb", programs.room_glb()[:300])
        refused = lightbatch("bake", broken, "-q", "-o", self.path("none"))
        self.assertEqual(refused.returncode, 3, refused.stderr)
        self.assertIn("broken.glb", refused.stderr)
        self.assertIn("INPUT_MALFORMED", refused.stderr)
        self.assertFalse(os.path.exists(self.path("none")))
        for words in [["bake"], ["bake", scene, "--target-error", "much"], ["roast", scene],
                      ["bake", self.path("missing.glb")], ["jobs"],
                      ["bake", scene, "--target-error", "2%", "--time-budget", "3s"],
                      ["bake", scene, "--sky", self.path("missing.hdr")], ["bake", self.folder], ["bake", "/dev/null"],
                      ["bake", scene, "-o", scene], ["bake", scene, "-o", scene + "/out"],
                      ["bake", scene, "-o", self.path("new"), "--report", self.path("no/r.json")],
                      ["hierarchy", scene, "-o", self.path("no/boxes.glb")],
                      ["scene", "office", "-o", self.path("no/office.glb")], ["scene", "house"],
                      ["plan", scene, "--seed", "-1"], ["plan", scene, "--seed", str(2**64)],
                      ["scene", "office", "--triangles", "1e4"],
                      ["bake", scene, "--target-error", ""], ["bake", scene, "--sky", ""],
                      ["bake", scene, "-o", ""], ["bake", ""], ["jobs", "--server", "localhost"],
                      ["jobs", "--server", "localhost:99999"], ["jobs", "--server", ":7411"]]:
            self.assertEqual(lightbatch(*words).returncode, 2, words)
        self.assertFalse(os.path.exists(self.path("new")))
        views = self.write("my views.json", b"[{}]")
        unseen = lightbatch("bake", scene, "-q", "-o", self.path("a/b"), "--cameras", views)
        self.assertEqual(unseen.returncode, 3, unseen.stderr)
        self.assertIn("my views.json#/0", unseen.stderr)
        self.assertFalse(os.path.exists(self.path("a")))
        lightbatch("bake", scene, "-q", "-o", self.path("bake"), "--texels-per-metre", "4")
        lights = self.write("my lights.json", b'{"foo": 1}')
        unknown = lightbatch("relight", self.path("bake"), "--lights", lights, "-q", "-o", self.path("b"))
        self.assertEqual(unknown.returncode, 2, unknown.stderr)
        self.assertIn("my lights.json#/foo", unknown.stderr)
        self.assertEqual(lightbatch("jobs", "--server", "127.0.0.1:1").returncode, 5)
        self.assertEqual(lightbatch("--help").returncode, 0)
        self.assertEqual(lightbatch("bake", "--help").returncode, 0)
        self.assertEqual(lightbatch("--version").returncode, 0)

    def test_unknown_commands_are_named(self):
        for words in (["roast", "room.glb"], ["scene", "house"]):
            self.assertIn("'%s'" % words[-1] if words[0] == "scene" else "'roast'",
                          lightbatch(*words).stderr)

    def test_a_missed_time_budget_is_told(self):
        scene = self.write("room.glb", programs.room_glb())
        for budget, missed in (("1ms", True), ("1h", False)):
            done = lightbatch("bake", scene, "-o", self.path("out"), "--texels-per-metre", "4",
                              "--time-budget", budget, "-q")
            self.assertIn(done.returncode, (0, 4), done.stderr)
            with open(self.path("out", "report.json")) as file:
                warnings = json.load(file)["warnings"]
            self.assertEqual(any("time budget" in w for w in warnings), missed, warnings)
            self.assertEqual("missed" in done.stdout, missed, done.stdout)

    def test_levels_may_be_named_twice(self):
        scene = self.write("room.glb", programs.room_glb())
        drawn = lightbatch("hierarchy", scene, "--levels", "1,0,1", "-q", "-o", self.path("boxes"))
        self.assertEqual(drawn.returncode, 0, drawn.stderr)
        self.assertEqual({name for name in os.listdir(self.path("boxes")) if name.endswith(".png")},
                         {"boxes_0.png", "boxes_1.png"})

    def test_file_names_of_all_kinds(self):
        for name in ["x" * 79 + "\u00fc.glb", "\u65e5\u672c" * 30 + ".glb", b"\xfc.glb", "back\\slash.glb", "new\nline.glb"]:
            scene = os.path.join(os.fsencode(self.folder), os.fsencode(name))
            with open(scene, "wb") as file:
                file.write(programs.room_glb())
            done = subprocess.run([programs.OPTIONS.client, "bake", scene, "-q", "--no-lightmaps",
                                   "-o", self.path("named")], capture_output=True, timeout=900)
            self.assertEqual(done.returncode, 0, (name, done.stderr))
            self.assertEqual(done.stderr, b"")

    def test_control_c_cancels(self):
        office = self.path("office.glb")
        lightbatch("scene", "office", "--triangles", "20000", "-o", office)
        process = subprocess.Popen(
            [programs.OPTIONS.client, "bake", office, "-o", self.path("out"), "--target-error",
             "0.5%"], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        for line in process.stderr:
            if line.startswith("jobs/"):
                break
        time.sleep(1)
        process.send_signal(signal.SIGINT)
        process.stderr.read()
        self.assertEqual(process.wait(timeout=30), 6)
        self.assertFalse(os.path.exists(self.path("out")))

    def test_a_daemon_keeps_jobs(self):
        scene = self.write("room.glb", programs.room_glb())
        daemon = programs.Daemon(self.path("data"))
        server = ["--server", daemon.address]
        done = lightbatch("bake", scene, "-o", self.path("out"), *SMALL, "--json", *server)
        self.assertIn(done.returncode, (0, 4), done.stderr)
        job = json.loads(done.stdout)["job"]
        cached = lightbatch("bake", scene, "-o", self.path("out2"), *SMALL, "--json", *server)
        self.assertTrue(json.loads(cached.stdout)["cache_hit"])
        listed = json.loads(lightbatch("jobs", "--json", *server).stdout)
        self.assertEqual([entry["state"] for entry in listed], ["SUCCEEDED", "SUCCEEDED"])
        watched = lightbatch("watch", job, *server)
        self.assertEqual(watched.returncode, done.returncode, watched.stderr)
        fetched = lightbatch("fetch", job, "-o", self.path("fetched"), *server)
        self.assertEqual(fetched.returncode, done.returncode, fetched.stderr)
        self.assertEqual(digests(self.path("fetched")), digests(self.path("out")))
        self.assertEqual(lightbatch("cancel", job, *server).returncode, 2)
        self.assertEqual(lightbatch("watch", "none", *server).returncode, 5)
        self.assertEqual(daemon.stop(), 0)


    def test_a_daemon_may_restart_under_its_clients(self):
        office = self.path("office.glb")
        lightbatch("scene", "office", "--triangles", "5000", "-o", office)
        daemon = programs.Daemon(self.path("data"))
        words = ["bake", office, "--texels-per-metre", "8", "--target-error", "5%", "--server", daemon.address]
        clients = [subprocess.Popen([programs.OPTIONS.client, *words, "--seed", str(seed), "-o", self.path(str(seed))],
                                    stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
                   for seed in (1, 2)]
        for client in clients:
            for line in client.stderr:
                if line.startswith("jobs/"):
                    break
        time.sleep(1)
        self.assertEqual(daemon.stop(), 0)
        daemon = programs.Daemon(self.path("data"), daemon.address)
        for client in clients:
            text = client.stderr.read()
            self.assertIn(client.wait(timeout=600), (0, 4), text)
        self.assertIn("scene.glb", os.listdir(self.path("1")))
        self.assertEqual(daemon.stop(), 0)
        with open(daemon.log) as log:
            self.assertIn('"job.requeued"', log.read())

    def test_a_daemon_names_what_its_options_lack(self):
        config = self.write("daemon.toml", b'listn = "127.0.0.1:0"\n')
        for words, told in ((["--config", config], "listn"), (["--listen", "here"], "HOST:PORT"),
                            (["--listen", "localhost:70000"], "HOST:PORT"), (["--log-level", "loud"], "loud")):
            refused = subprocess.run([programs.OPTIONS.daemon, "--data", self.path("data"), *words],
                                     capture_output=True, text=True, timeout=30)
            self.assertEqual(refused.returncode, 2, words)
            self.assertIn(told, refused.stderr)
        self.assertFalse(os.path.exists(self.path("data")))


if __name__ == "__main__":
    programs.run(CommandLine)
