#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "lightbatch/v1/job_service.pb.h"
#include "lightbatch/v1/scene_service.pb.h"
#include "server/blob_store.h"

namespace lightbatch::server {

struct RunLimits {
  std::int64_t memory_bytes = 0;    // of one job's process; 0: not limited
  double job_seconds = 24 * 3600;   // of one attempt
  double cancel_grace_seconds = 2;  // between asking a worker to stop and killing it
};

/// How one attempt ended.
struct RunResult {
  Status status;   // OK, CANCELLED, or why it failed
  int signal = 0;  // of WORKER_CRASHED
  bool missed_target = false;
  std::string summary;
  std::vector<v1::Artifact> artifacts;  // in the blob store, sorted by path
  std::int64_t peak_memory_bytes = 0;
};

/// Runs one job in a child process and takes its files into the blob store. Blocks the calling
/// thread, which must live as long as the child (the child dies with it). Several threads may run
/// jobs through one runner.
class JobRunner {
 public:
  /// `work` is emptied.
  JobRunner(std::filesystem::path work, BlobStore& blobs, const RunLimits& limits);

  /// Setting `cancel` ends the run with CANCELLED. A worker that crashes, runs out of memory or
  /// overruns its time fails with WORKER_CRASHED, WORKER_OOM, TIMEOUT.
  RunResult run(const v1::Job& job, const v1::Scene& scene, const std::atomic<bool>& cancel,
                const std::function<void(std::string_view phase, double fraction)>& progress);

 private:
  Status prepare(const v1::Job& job, const v1::Scene& scene, double seconds,
                 const std::filesystem::path& folder) const;
  Status collect(const std::vector<std::string>& names, const std::filesystem::path& folder,
                 RunResult& result);

  const std::filesystem::path work_;
  BlobStore& blobs_;
  const RunLimits limits_;
};

}  // namespace lightbatch::server
