#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "lightbatch/v1/job_service.grpc.pb.h"
#include "tests/server/test_service.h"

namespace lightbatch::server::test {
namespace {

using Clock = std::chrono::steady_clock;

v1::SubmitJobRequest no_cache() {
  v1::SubmitJobRequest request;
  request.set_cache_policy(v1::CACHE_POLICY_OFF);
  return request;
}

TEST(JobService, RunsAJobAndGivesItsFiles) {
  TestService service;
  const v1::Job job = service.run("ok");
  ASSERT_EQ(job.state(), v1::JOB_STATE_SUCCEEDED) << job.error().message();
  EXPECT_EQ(job.verdict(), v1::VERDICT_DONE);
  EXPECT_EQ(job.summary(), "a test job\n");
  EXPECT_EQ(job.attempt(), 1);
  EXPECT_GT(job.peak_memory_bytes(), 0);
  ASSERT_EQ(job.artifacts_size(), 2);
  EXPECT_EQ(job.artifacts(0).media_type(), "text/html");
  EXPECT_EQ(*service.client().read_blob(job.artifacts(1).digest()), "ok");
  EXPECT_EQ(service.run("missed").verdict(), v1::VERDICT_MISSED_TARGET);
}

TEST(JobService, UnchangedInputComesFromTheCache) {
  TestService service;
  const v1::Job first = service.run("ok");
  EXPECT_FALSE(first.cache_hit());
  const v1::Job second = service.submit("ok");
  EXPECT_EQ(second.state(), v1::JOB_STATE_SUCCEEDED);
  EXPECT_TRUE(second.cache_hit());
  EXPECT_NE(second.name(), first.name());
  EXPECT_EQ(second.artifacts(1).digest().sha256(), first.artifacts(1).digest().sha256());
  EXPECT_FALSE(service.run("ok", no_cache()).cache_hit());
  v1::SubmitJobRequest other;
  other.mutable_options()->set_seed(5);
  EXPECT_FALSE(service.run("ok", other).cache_hit());
}

TEST(JobService, RequestIdsAreIdempotent) {
  TestService service;
  v1::SubmitJobRequest request = no_cache();
  request.set_request_id("6f1c");
  const v1::Job first = service.submit("ok", request);
  EXPECT_EQ(service.submit("ok", request).name(), first.name());
  service.restart();
  EXPECT_EQ(service.submit("ok", request).name(), first.name());
  request.set_scene(service.scene("ok"));
  request.set_display_name("another body");
  const auto reused = service.client().submit(request);
  ASSERT_FALSE(reused.ok());
  EXPECT_EQ(reused.error().reason, "REQUEST_ID_REUSED");
}

TEST(JobService, BadRequestsAreRefusedBeforeAJobExists) {
  TestService service;
  v1::SubmitJobRequest request;
  request.set_scene(service.scene("ok"));
  const auto refused = [&] {
    const auto job = service.client().submit(request);
    return job.ok() ? std::string("taken") : job.error().reason;
  };
  request.mutable_options()->set_target_error(0.1);
  request.mutable_options()->set_time_budget_seconds(3);
  EXPECT_EQ(refused(), "BAD_OPTION");
  request.clear_options();
  request.mutable_options()->set_sky_file("sky.hdr");
  EXPECT_EQ(refused(), "BAD_OPTION");
  request.clear_options();
  request.mutable_timeout()->set_seconds(-1);
  EXPECT_EQ(refused(), "BAD_REQUEST");
  request.clear_timeout();
  request.set_scene("scenes/none");
  EXPECT_EQ(refused(), "SCENE_NOT_FOUND");
  EXPECT_EQ(service.client().get("jobs/none").error().reason, "JOB_NOT_FOUND");
  EXPECT_EQ(service.client().get("none").error().reason, "BAD_REQUEST");
  EXPECT_EQ(service.client().list({})->jobs_size(), 0);
}

TEST(JobService, CancelQueuedAndRunning) {
  TestService service;
  const v1::Job running = service.submit("slow");
  service.wait_for(running.name(), v1::JOB_STATE_RUNNING);
  const v1::Job queued = service.submit("ok");
  EXPECT_EQ(service.client().cancel(queued.name())->state(), v1::JOB_STATE_CANCELLED);
  EXPECT_EQ(service.client().cancel(queued.name())->state(), v1::JOB_STATE_CANCELLED);
  const auto start = Clock::now();
  EXPECT_EQ(service.client().cancel(running.name())->state(), v1::JOB_STATE_CANCELLING);
  const v1::Job ended = service.wait_for(running.name(), v1::JOB_STATE_CANCELLED);
  EXPECT_EQ(ended.state(), v1::JOB_STATE_CANCELLED);
  EXPECT_LT(Clock::now() - start, std::chrono::seconds(2));
  const v1::Job done = service.run("ok");
  EXPECT_EQ(service.client().cancel(done.name()).error().reason, "JOB_ALREADY_ENDED");
}

TEST(JobService, AJobThatDoesNotListenIsKilled) {
  TestService service;
  const v1::Job job = service.submit("deaf");
  service.wait_for(job.name(), v1::JOB_STATE_RUNNING);
  static_cast<void>(service.client().cancel(job.name()));
  EXPECT_EQ(service.wait_for(job.name(), v1::JOB_STATE_CANCELLED).state(), v1::JOB_STATE_CANCELLED);
}

TEST(JobService, WatchGoesOnAtItsCursor) {
  TestService service;
  const v1::Job job = service.submit("slow");
  std::int64_t seen = 0;
  int events = 0;
  static_cast<void>(service.client().watch(job.name(), [&](const v1::Job& now) {
    EXPECT_GT(now.sequence(), seen);
    seen = now.sequence();
    return ++events < 4;
  }));
  EXPECT_EQ(events, 4);
  auto calls = v1::JobService::NewStub(service.channel());
  grpc::ClientContext context;
  v1::WatchJobRequest request;
  request.set_name(job.name());
  request.set_after_sequence(seen);
  auto stream = calls->WatchJob(&context, request);
  v1::JobEvent event;
  ASSERT_TRUE(stream->Read(&event));
  EXPECT_GT(event.sequence(), seen);
  EXPECT_EQ(event.job().progress().phase(), "spend");
  // Leaving a watch leaves the job alone.
  context.TryCancel();
  while (stream->Read(&event)) continue;
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_EQ(service.client().get(job.name())->state(), v1::JOB_STATE_RUNNING);
  static_cast<void>(service.client().cancel(job.name()));
  const v1::Job ended = service.wait_for(job.name(), v1::JOB_STATE_CANCELLED);
  // A cursor at the end: the stream ends without an event.
  grpc::ClientContext last_context;
  request.set_after_sequence(ended.sequence());
  auto last = calls->WatchJob(&last_context, request);
  EXPECT_FALSE(last->Read(&event));
  EXPECT_TRUE(last->Finish().ok());
}

TEST(JobService, ARestartPutsRunningJobsBack) {
  TestService service;
  const v1::Job slow = service.submit("slow");
  const std::int64_t before = service.wait_for(slow.name(), v1::JOB_STATE_RUNNING).sequence();
  const v1::Job waiting = service.submit("ok", no_cache());
  service.restart();
  const v1::Job again = service.wait_for(slow.name(), v1::JOB_STATE_RUNNING);
  EXPECT_EQ(again.attempt(), 1) << "a clean stop does not use up an attempt";
  EXPECT_GT(again.sequence(), before);
  static_cast<void>(service.client().cancel(slow.name()));
  EXPECT_EQ(service.wait_for(waiting.name(), v1::JOB_STATE_SUCCEEDED).state(),
            v1::JOB_STATE_SUCCEEDED);
}

TEST(JobService, StopEndsStreamsAsUnavailable) {
  TestService service;
  const v1::Job job = service.submit("slow");
  auto calls = v1::JobService::NewStub(service.channel());
  grpc::ClientContext context;
  v1::WatchJobRequest request;
  request.set_name(job.name());
  auto stream = calls->WatchJob(&context, request);
  v1::JobEvent event;
  ASSERT_TRUE(stream->Read(&event));
  const auto start = Clock::now();
  std::thread stopper([&] { service.service().stop(); });
  while (stream->Read(&event)) continue;
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
  stopper.join();
  EXPECT_LT(Clock::now() - start, std::chrono::seconds(3));
}

TEST(JobService, ListsInPagesByState) {
  TestService service;
  for (int i = 0; i < 5; ++i) service.run("ok", no_cache());
  service.run("malformed");
  v1::ListJobsRequest request;
  request.set_page_size(2);
  request.set_state(v1::JOB_STATE_SUCCEEDED);
  int seen = 0;
  do {
    const auto page = service.client().list(request);
    ASSERT_TRUE(page.ok());
    seen += page->jobs_size();
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  EXPECT_EQ(seen, 5);
  request.set_page_token("nonsense");
  EXPECT_EQ(service.client().list(request).error().reason, "BAD_PAGE_TOKEN");
}

TEST(JobService, AFullQueueRefuses) {
  ServiceConfig config;
  config.admission.max_queued_jobs = 2;
  TestService service(config);
  const v1::Job slow = service.submit("slow");
  service.wait_for(slow.name(), v1::JOB_STATE_RUNNING);
  service.submit("sleep 1");
  service.submit("sleep 2");
  v1::SubmitJobRequest request;
  request.set_scene(service.scene("sleep 3"));
  EXPECT_EQ(service.client().submit(request).error().reason, "QUOTA_EXCEEDED");
}

}  // namespace
}  // namespace lightbatch::server::test
