#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "server/blob_store.h"
#include "server/job_runner.h"
#include "server/job_store.h"

namespace lightbatch::server {

/// Where jobs change state: every transition is written to the store before anyone hears of it.
/// QUEUED -> RUNNING -> SUCCEEDED | FAILED | CANCELLED; CANCELLING between; RUNNING -> QUEUED when
/// the server stops. Progress lives in memory alone. Thread-safe.
class JobBoard {
 public:
  JobBoard(JobStore& store, const BlobStore& blobs, std::int64_t max_queued)
      : store_(store), blobs_(blobs), max_queued_(max_queued) {}

  /// Takes a checked submission: from the cache when `use_cache` and a result is there, else into
  /// the queue. QUOTA_EXCEEDED, DRAINING, REQUEST_ID_REUSED.
  Result<v1::Job> submit(JobStore::Submission submission, bool use_cache);
  /// The job as it is now, progress included.
  Result<v1::Job> get(const std::string& name);
  Result<v1::ListJobsResponse> list(const v1::ListJobsRequest& request);
  /// JOB_ALREADY_ENDED, JOB_NOT_FOUND.
  Result<v1::Job> cancel(const std::string& name);

  /// Calls `changed` after each change of the job, from any thread; it must only post work.
  std::uint64_t watch(const std::string& name, std::function<void()> changed);
  void unwatch(const std::string& name, std::uint64_t token);

  /// A job that runs now, for the thread that runs it.
  struct Claim {
    v1::Job job;
    std::shared_ptr<const std::atomic<bool>> cancel;
  };
  /// Waits for a queued job and makes it RUNNING; nothing once stop() was called.
  std::optional<Claim> claim();
  void progress(const std::string& name, std::string_view phase, double fraction);
  /// Ends a claimed job as the run says; after stop() an interrupted job goes back to the queue.
  /// Returns the state that the job has now: QUEUED when it was stopped with the server.
  v1::JobState end(const std::string& name, RunResult result);

  /// No new jobs (submit: DRAINING), claims end, running jobs are told to stop; watchers are
  /// called once more.
  void stop();
  bool stopping() const { return stopping_; }
  Result<std::array<std::int64_t, 7>> counts() { return store_.counts(); }

 private:
  struct Live {
    v1::Job job;
    std::shared_ptr<std::atomic<bool>> cancel;
    std::chrono::steady_clock::time_point phase_start;
    std::chrono::steady_clock::time_point told;  // last progress shown to watchers
  };
  Result<std::optional<v1::Job>> from_cache(const JobStore::Submission& submission);
  v1::Job snapshot(const Live& live) const;
  void notify(const std::string& name);

  JobStore& store_;
  const BlobStore& blobs_;
  const std::int64_t max_queued_;
  std::atomic<bool> stopping_ = false;
  std::mutex mutex_;
  std::condition_variable queued_;
  std::map<std::string, Live> live_;
  std::map<std::string, std::map<std::uint64_t, std::function<void()>>> watchers_;
  std::uint64_t next_token_ = 1;
};

}  // namespace lightbatch::server
