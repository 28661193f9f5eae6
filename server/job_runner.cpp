#include "server/job_runner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "server/child_process.h"
#include "server/log.h"
#include "server/names.h"
#include "server/timestamps.h"
#include "server/worker.h"

namespace lightbatch::server {
namespace {

using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kMaxSummaryBytes = 64 * 1024;

std::string media_type(const std::filesystem::path& file) {
  static const std::map<std::string, std::string> types = {
      {".glb", "model/gltf-binary"}, {".gltf", "model/gltf+json"},  {".exr", "image/x-exr"},
      {".png", "image/png"},         {".json", "application/json"}, {".html", "text/html"},
      {".csv", "text/csv"},          {".svg", "image/svg+xml"},     {".txt", "text/plain"}};
  const auto found = types.find(file.extension().string());
  return found == types.end() ? "application/octet-stream" : found->second;
}

/// What the worker said, frame by frame.
struct Conversation {
  Json done;
  Json error;

  void hear(std::string_view frame, const std::function<void(std::string_view, double)>& progress) {
    const Json json = Json::parse(frame, nullptr, false);
    if (!json.is_object()) return;
    if (json.contains("done")) done = json["done"];
    if (json.contains("error")) error = json["error"];
    if (json.contains("phase")) progress(json.value("phase", ""), json.value("fraction", 0.0));
  }
};

/// The end of the worker's stderr: for the log, not for clients.
std::string last_words(const std::filesystem::path& folder) {
  std::ifstream file(folder / "stderr.log", std::ios::binary | std::ios::ate);
  if (!file) return {};
  const std::streamoff size = file.tellg();
  const std::streamoff keep = std::min<std::streamoff>(size, 2000);
  file.seekg(size - keep);
  std::string text(static_cast<std::size_t>(keep), '\0');
  file.read(text.data(), keep);
  return text;
}

Status crashed(const ChildExit& exit) {
  if (exit.signal == SIGKILL) {
    return Status(StatusCode::kResourceExhausted, "WORKER_OOM",
                  "the system killed the job's process, most likely for its memory; ask for less "
                  "or give the machine more");
  }
  if (exit.signal == SIGXCPU) {
    return Status(StatusCode::kDeadlineExceeded, "TIMEOUT",
                  "the job used up its processor time; allow more (timeout) or ask for less");
  }
  const std::string how = exit.signal != 0
                              ? std::string("died of signal ") + std::to_string(exit.signal) +
                                    " (" + strsignal(exit.signal) + ")"
                              : "ended with code " + std::to_string(exit.code) + " and no result";
  return Status(StatusCode::kInternal, "WORKER_CRASHED",
                "the job's process " + how +
                    "; other jobs are not affected. Please report this "
                    "scene as a fault of the program");
}

Status reported(const Json& error) {
  const int code = error.value("code", static_cast<int>(StatusCode::kInternal));
  return Status(code > 0 && code <= 16 ? static_cast<StatusCode>(code) : StatusCode::kInternal,
                error.value("reason", "INTERNAL"), error.value("message", ""),
                error.value("place", ""));
}

}  // namespace

JobRunner::JobRunner(std::filesystem::path work, BlobStore& blobs, const RunLimits& limits)
    : work_(std::move(work)), blobs_(blobs), limits_(limits) {
  std::error_code ignored;
  std::filesystem::remove_all(work_, ignored);
  std::filesystem::create_directories(work_, ignored);
}

Status JobRunner::prepare(const v1::Job& job, const v1::Scene& scene, double seconds,
                          const std::filesystem::path& folder) const {
  std::error_code error;
  std::filesystem::create_directories(folder / "out", error);
  if (error) return io_error(job.name(), "cannot create a work folder: " + error.message());
  WorkerRequest request;
  request.options = job.options();
  request.scene = scene.main_path();
  for (const v1::SceneFile& file : scene.files()) {
    if (!blobs_.has(file.digest())) {
      return Status(StatusCode::kFailedPrecondition, "BLOB_MISSING",
                    "a file of the scene is not in the store any more", file.path());
    }
    request.files[file.path()] = std::filesystem::absolute(blobs_.path(file.digest().sha256()));
  }
  request.memory_bytes = limits_.memory_bytes;
  const double threads = std::max(1u, std::thread::hardware_concurrency());
  request.cpu_seconds = static_cast<std::int64_t>(std::ceil(seconds * threads)) + 60;
  return write_request(request, folder);
}

Status JobRunner::collect(const std::vector<std::string>& names,
                          const std::filesystem::path& folder, RunResult& result) {
  for (const std::string& name : names) {
    LB_RETURN_IF_ERROR(check_path(name));
    v1::Artifact artifact;
    artifact.set_path(name);
    artifact.set_media_type(media_type(name));
    LB_ASSIGN_OR_RETURN(*artifact.mutable_digest(), blobs_.take(folder / "out" / name));
    result.artifacts.push_back(std::move(artifact));
  }
  std::sort(result.artifacts.begin(), result.artifacts.end(),
            [](const v1::Artifact& a, const v1::Artifact& b) { return a.path() < b.path(); });
  return {};
}

RunResult JobRunner::run(const v1::Job& job, const v1::Scene& scene,
                         const std::atomic<bool>& cancel,
                         const std::function<void(std::string_view, double)>& progress) {
  RunResult result;
  const double seconds = job.has_timeout() ? to_seconds(job.timeout()) : limits_.job_seconds;
  const std::filesystem::path folder = std::filesystem::absolute(
      work_ / (job.name().substr(5) + "-" + std::to_string(job.attempt())));
  result.status = prepare(job, scene, seconds, folder);
  Conversation talk;
  bool late = false;
  const auto deadline = Clock::now() + std::chrono::duration<double>(seconds);
  if (result.status.ok()) {
    const auto exit = run_child(
        folder, limits_.cancel_grace_seconds,
        [&](std::string_view frame) { talk.hear(frame, progress); },
        [&] {
          late = late || Clock::now() > deadline;
          if (late) return ChildOrder::kKill;
          return cancel ? ChildOrder::kStop : ChildOrder::kGoOn;
        });
    if (!exit.ok()) {
      result.status = exit.status();
    } else {
      result.peak_memory_bytes = exit->peak_memory_bytes;
      if (!talk.done.is_null()) {
        result.status =
            collect(talk.done.value("artifacts", std::vector<std::string>()), folder, result);
        result.missed_target = talk.done.value("missed_target", false);
        result.summary = talk.done.value("summary", "").substr(0, kMaxSummaryBytes);
      } else if (cancel) {
        result.status = cancelled();
      } else if (late) {
        result.status =
            Status(StatusCode::kDeadlineExceeded, "TIMEOUT",
                   "the job ran longer than its " + std::to_string(std::llround(seconds)) +
                       " s; allow more (timeout) or ask for less");
      } else if (!talk.error.is_null()) {
        result.status = reported(talk.error);
      } else {
        result.status = crashed(*exit);
        result.signal = exit->signal;
        log_event(LogLevel::kError, "worker.crashed",
                  {{"job", job.name()},
                   {"signal", std::to_string(exit->signal)},
                   {"code", std::to_string(exit->code)},
                   {"stderr", last_words(folder)}});
      }
    }
  }
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  return result;
}

}  // namespace lightbatch::server
