#pragma once

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "lightbatch/v1/job_options.pb.h"
#include "server/engine.h"

namespace lightbatch::server {

/// The child process of one job. The parent writes a WorkerRequest into an empty folder and starts
/// its own executable with kWorkerArgument and that folder; the child locks itself in, runs the
/// job and writes frames to descriptor kFrameDescriptor: a 32-bit little-endian length and that
/// many bytes of JSON, either {"phase", "fraction"} or, last, {"done"} or {"error"}.
/// The folder holds: request.json and options.pb (parent), out/ and stderr.log (child).

constexpr const char* kWorkerArgument = "--lightbatch-worker";
constexpr int kFrameDescriptor = 3;
constexpr std::uint32_t kMaxFrameBytes = 1u << 20;

struct WorkerRequest {
  v1::JobOptions options;
  std::string scene;                         // main file, a key of files
  std::map<std::string, std::string> files;  // manifest path -> blob file
  std::int64_t memory_bytes = 0;             // address space; 0: not limited
  std::int64_t cpu_seconds = 0;              // of all threads; 0: not limited
};
Status write_request(const WorkerRequest& request, const std::filesystem::path& folder);

/// Programs that embed the service call this first in main. When the arguments ask for a worker it
/// runs the job and returns the exit code; otherwise it returns nothing and changes nothing.
std::optional<int> run_worker_if_asked(int argc, char** argv, const Engine& engine);

}  // namespace lightbatch::server
