#pragma once

#include <grpcpp/impl/service_type.h>

#include <atomic>
#include <cstdint>
#include <memory>

#include "server/blob_store.h"
#include "server/engine.h"
#include "server/executor.h"
#include "server/idle_guard.h"
#include "server/job_board.h"
#include "server/metrics.h"
#include "server/scene_store.h"

namespace lightbatch::server {

constexpr int kMaxMessageBytes = 4 << 20;
constexpr std::int64_t kMaxUploadChunk = std::int64_t{2} << 20;
constexpr std::int64_t kReadChunk = std::int64_t{1} << 19;

struct AdmissionLimits {
  int max_uploads = 256;
  int max_watchers = 1000;
  std::int64_t max_queued_jobs = 1000;
  double max_job_seconds = 24 * 3600;
  std::int64_t job_memory_bytes = 0;
  int concurrent_jobs = 1;
};

/// What every service works on. Outlives the services.
struct ServiceContext {
  BlobStore& blobs;
  SceneStore& scenes;
  JobBoard& board;
  Executor& executor;
  Metrics& metrics;
  IdleGuard& idle;
  Engine engine;
  AdmissionLimits limits;
};

/// One per service of the interface; each lives in a file of its own name.
std::unique_ptr<grpc::Service> make_blob_service(ServiceContext& context);
std::unique_ptr<grpc::Service> make_scene_service(ServiceContext& context);
std::unique_ptr<grpc::Service> make_job_service(ServiceContext& context);
std::unique_ptr<grpc::Service> make_capability_service(ServiceContext& context);

}  // namespace lightbatch::server
