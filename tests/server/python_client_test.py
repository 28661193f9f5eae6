#!/usr/bin/env python3
"""The interface as another language sees it, on a daemon with made-up jobs (server_test_daemon):
uploads cut and resumed, watching, cancelling, errors with details, kill -9 of the daemon while jobs
run and uploads are under way.
"""
import os
import time
import urllib.request

import grpc

import daemon_client as client


class Behaviour(client.WithDaemon):
    def test_upload_bake_watch_download(self):
        job = client.submit(self.daemon, "sleep 700")
        phases, fractions = [], []
        last = 0
        for event in self.daemon.jobs.WatchJob(
                client.STUBS.job_service.WatchJobRequest(name=job.name)):
            self.assertGreater(event.sequence, last)
            last = event.sequence
            phases.append(event.job.progress.phase)
            fractions.append(event.job.progress.fraction)
        self.assertIn("spend", phases)
        self.assertTrue(any(0 < fraction < 1 for fraction in fractions))
        done = event.job
        self.assertEqual(done.state, client.STUBS.job_service.JOB_STATE_SUCCEEDED)
        result = next(a for a in done.artifacts if a.path == "result.txt")
        self.assertEqual(client.read_blob(self.daemon, result.digest), b"sleep 700")
        self.assertEqual(client.read_blob(self.daemon, result.digest, 6, 2), b"70")
        page = urllib.request.urlopen(
            "http://127.0.0.1:%d/%s/report" % (self.daemon.admin, done.name)).read()
        self.assertIn(b"report of a test", page)

    def test_cancel(self):
        job = client.submit(self.daemon, "slow")
        client.wait_running(self.daemon, job.name)
        start = time.monotonic()
        self.daemon.jobs.CancelJob(client.STUBS.job_service.CancelJobRequest(name=job.name))
        self.assertEqual(client.watch_to_end(self.daemon, job.name).state,
                         client.STUBS.job_service.JOB_STATE_CANCELLED)
        self.assertLess(time.monotonic() - start, 5)

    def test_errors_carry_reason_and_place(self):
        with self.assertRaises(grpc.RpcError) as caught:
            client.get(self.daemon, "jobs/none")
        self.assertEqual(caught.exception.code(), grpc.StatusCode.NOT_FOUND)
        self.assertEqual(client.detail_of(caught.exception).reason, "JOB_NOT_FOUND")
        data = b"x" * 1000
        with self.assertRaises(grpc.RpcError) as caught:
            self.daemon.blobs.UploadBlob(client.requests(data, offset=10))
        self.assertEqual(client.detail_of(caught.exception).reason, "OFFSET_MISMATCH")
        self.assertEqual(client.detail_of(caught.exception).metadata["committed_size"], "0")
        job = client.watch_to_end(self.daemon, client.submit(self.daemon, "malformed").name)
        self.assertEqual(job.error.detail.reason, "INPUT_MALFORMED")
        self.assertEqual(job.error.detail.place, "scene.gltf#/nodes/3")
        job = client.watch_to_end(self.daemon, client.submit(self.daemon, "crash").name)
        self.assertEqual(job.error.detail.reason, "WORKER_CRASHED")

    def test_cut_upload_resumes(self):
        data = os.urandom(20 << 20)
        digest = client.digest_of(data)
        call = self.daemon.blobs.UploadBlob.future(client.requests(data, end=18 << 20, pause=0.01))
        client.wait_until(lambda: self.daemon.blobs.QueryUpload(
            client.STUBS.blob_service.QueryUploadRequest(digest=digest)).committed_size > 0)
        call.cancel()
        query = client.STUBS.blob_service.QueryUploadRequest(digest=digest)
        client.wait_until(lambda: self.quiet(query))
        state = self.daemon.blobs.QueryUpload(query)
        self.assertFalse(state.complete)
        response = self.daemon.blobs.UploadBlob(client.requests(data, offset=state.committed_size))
        self.assertEqual(response.committed_size, len(data))
        self.assertEqual(client.read_blob(self.daemon, digest), data)

    def quiet(self, query):
        before = self.daemon.blobs.QueryUpload(query).committed_size
        time.sleep(0.2)
        return self.daemon.blobs.QueryUpload(query).committed_size == before

    def test_health_reflection_capabilities_metrics(self):
        # The health messages by hand: HealthCheckRequest{service=1}, HealthCheckResponse{status=1}.
        check = self.daemon.channel.unary_unary("/grpc.health.v1.Health/Check")
        for service in [b"", b"lightbatch.v1.JobService"]:
            self.assertEqual(check(b"\x0a" + bytes([len(service)]) + service), b"\x08\x01")
        # ServerReflectionRequest{list_services=7}
        reflect = self.daemon.channel.stream_stream(
            "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo")
        answer = next(reflect(iter([b"\x3a\x01*"])))
        self.assertIn(b"lightbatch.v1.JobService", answer)
        capabilities = self.daemon.capabilities.GetCapabilities(
            client.STUBS.capability_service.GetCapabilitiesRequest())
        self.assertEqual(capabilities.max_message_bytes, 4 << 20)
        text = urllib.request.urlopen(
            "http://127.0.0.1:%d/metrics" % self.daemon.admin).read().decode()
        self.assertIn('lightbatch_jobs{state="queued"} 0', text)

    def test_kill_9_loses_nothing(self):
        """The daemon is killed again and again while jobs run and a blob is on its way."""
        data = os.urandom(48 << 20)
        digest = client.digest_of(data)
        query = client.STUBS.blob_service.QueryUploadRequest(digest=digest)
        names = [client.submit(self.daemon, "sleep %d" % (900 + i)).name for i in range(3)]
        small = os.urandom(100_000)
        client.upload(self.daemon, small)
        acknowledged = 0
        for _ in range(2):
            state = self.daemon.blobs.QueryUpload(query)
            self.assertGreaterEqual(state.committed_size, acknowledged)
            call = self.daemon.blobs.UploadBlob.future(
                client.requests(data, offset=state.committed_size, chunk=512 * 1024, pause=0.005))
            start = state.committed_size
            client.wait_until(lambda: self.daemon.blobs.QueryUpload(query).committed_size > start)
            client.wait_until(lambda: any(client.get(self.daemon, name).state ==
                                   client.STUBS.job_service.JOB_STATE_RUNNING for name in names))
            acknowledged = self.daemon.blobs.QueryUpload(query).committed_size
            self.daemon.kill()
            with self.assertRaises(grpc.RpcError):
                call.result()
            self.daemon.start()
        state = self.daemon.blobs.QueryUpload(query)
        self.assertGreaterEqual(state.committed_size, acknowledged)
        self.assertGreater(state.committed_size, 0)
        self.daemon.blobs.UploadBlob(client.requests(data, offset=state.committed_size))
        self.assertEqual(client.read_blob(self.daemon, digest), data)
        self.assertEqual(client.read_blob(self.daemon, client.digest_of(small)), small)
        listed = {job.name for job in self.daemon.jobs.ListJobs(
            client.STUBS.job_service.ListJobsRequest()).jobs}
        self.assertEqual(listed, set(names))
        for name in names:
            self.assertEqual(client.watch_to_end(self.daemon, name).state,
                             client.STUBS.job_service.JOB_STATE_SUCCEEDED)

    def test_no_worker_outlives_its_daemon(self):
        job = client.submit(self.daemon, "deaf")
        client.wait_running(self.daemon, job.name)
        client.wait_until(lambda: self.workers())
        workers = self.workers()
        self.daemon.kill()
        client.wait_until(lambda: not any(os.path.exists("/proc/%d" % pid) and
                                   open("/proc/%d/stat" % pid).read().split()[2] != "Z"
                                   for pid in workers))
        self.daemon.start()
        self.assertEqual(client.get(self.daemon, job.name).name, job.name)
        self.daemon.jobs.CancelJob(client.STUBS.job_service.CancelJobRequest(name=job.name))
        client.watch_to_end(self.daemon, job.name)

    def workers(self):
        task = "/proc/%d/task" % self.daemon.process.pid
        return [int(pid) for thread in os.listdir(task)
                for pid in open("%s/%s/children" % (task, thread)).read().split()]

    def test_three_crashes_of_the_daemon_exhaust_a_job(self):
        job = client.submit(self.daemon, "slow")
        for attempt in range(1, 4):
            client.wait_until(lambda: client.get(self.daemon, job.name).attempt == attempt)
            self.daemon.kill()
            self.daemon.start()
        failed = client.get(self.daemon, job.name)
        self.assertEqual(failed.state, client.STUBS.job_service.JOB_STATE_FAILED)
        self.assertEqual(failed.error.detail.reason, "ATTEMPTS_EXHAUSTED")


if __name__ == "__main__":
    client.run(Behaviour)
