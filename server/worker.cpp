#include "server/worker.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <new>
#include <nlohmann/json.hpp>

#include "core/base/bytes.h"
#include "server/sandbox.h"
#include "server/submission.h"

namespace lightbatch::server {
namespace {

using Json = nlohmann::json;

constexpr auto kProgressInterval = std::chrono::milliseconds(50);

std::atomic<bool> cancel_asked = false;
extern "C" void ask_cancel(int) { cancel_asked = true; }

/// Writes one frame; false when the parent is gone.
bool send_frame(std::string_view json) {
  const auto size = static_cast<std::uint32_t>(json.size());
  std::string frame;
  for (int shift = 0; shift < 32; shift += 8) frame += static_cast<char>((size >> shift) & 255);
  frame += json;
  for (std::string_view rest = frame; !rest.empty();) {
    const ssize_t put = ::write(kFrameDescriptor, rest.data(), rest.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return false;
    rest.remove_prefix(static_cast<std::size_t>(put));
  }
  return true;
}

// Made before the job starts: sending it needs no memory.
constexpr std::string_view kOutOfMemory =
    R"json({"error":{"code":8,"reason":"WORKER_OOM","place":"","message":)json"
    R"json("the job ran out of its memory limit; allow more (--job-memory) or ask for less )json"
    R"json((fewer texels, a smaller scene)"}})json";

[[noreturn]] void on_terminate() {
  if (const std::exception_ptr exception = std::current_exception()) {
    try {
      std::rethrow_exception(exception);
    } catch (const std::bad_alloc&) {
      send_frame(kOutOfMemory);
      std::_Exit(1);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "uncaught exception: %s\n", error.what());
    } catch (...) {
      std::fprintf(stderr, "uncaught exception\n");
    }
  }
  std::abort();
}

/// Before any byte of the scene is looked at.
void lock_in(const Json& request) {
  enter_sandbox({.memory_bytes = request.at("memory_bytes").get<std::int64_t>(),
                 .cpu_seconds = request.at("cpu_seconds").get<std::int64_t>(),
                 .parent = request.at("parent").get<pid_t>(),
                 .highest_descriptor = kFrameDescriptor});
  struct sigaction action = {};
  action.sa_handler = ask_cancel;
  sigaction(SIGTERM, &action, nullptr);
  action.sa_handler = SIG_IGN;
  sigaction(SIGPIPE, &action, nullptr);
  std::set_terminate(on_terminate);
}

Json error_json(const Status& status) {
  return {{"error",
           {{"code", static_cast<int>(status.code())},
            {"reason", status.reason()},
            {"message", status.message().substr(0, 8192)},
            {"place", status.place().substr(0, 2048)}}}};
}

/// Sends what a stage reports, at most every 50 ms within a phase.
class ProgressSender {
 public:
  void operator()(std::string_view phase, double fraction) {
    const std::lock_guard lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    if (phase == phase_ && now - sent_ < kProgressInterval) return;
    phase_ = phase;
    sent_ = now;
    const Json frame = {{"phase", phase_.substr(0, 64)}, {"fraction", fraction}};
    if (!send_frame(frame.dump(-1, ' ', false, Json::error_handler_t::replace))) {
      cancel_asked = true;
    }
  }

 private:
  std::mutex mutex_;
  std::string phase_;
  std::chrono::steady_clock::time_point sent_;
};

Json run(const std::filesystem::path& folder, const Json& request, const Engine& engine) {
  v1::JobOptions options;
  auto bytes = read_file(folder / "options.pb");
  if (!bytes.ok()) return error_json(bytes.status());
  if (!options.ParseFromArray(bytes->data(), static_cast<int>(bytes->size()))) {
    return error_json(bad_option("the options cannot be read"));
  }
  const auto converted = to_pipeline(options);
  if (!converted.ok()) return error_json(converted.status());
  pipeline::JobInput input;
  input.scene = request.at("scene").get<std::string>();
  for (const auto& [path, file] : request.at("files").items()) {
    input.files.emplace(path, file.get<std::string>());
  }
  ProgressSender sender;
  const Progress progress([&](std::string_view phase, double done) { sender(phase, done); },
                          &cancel_asked);
  const auto outcome = engine.run_job(*converted, input, folder / "out", progress);
  if (!outcome.ok()) return error_json(outcome.status());
  return {{"done",
           {{"missed_target", outcome->verdict == pipeline::Verdict::kMissedTarget},
            {"artifacts", outcome->artifacts},
            {"summary", outcome->summary}}}};
}

int work(const std::filesystem::path& folder, const Engine& engine) {
  auto text = read_file(folder / "request.json");
  if (!text.ok()) return 1;
  const Json request = Json::parse(as_text(*text));
  lock_in(request);
  Json last;
  try {
    last = run(folder, request, engine);
  } catch (const std::bad_alloc&) {
    return send_frame(kOutOfMemory) ? 0 : 1;
  }
  return send_frame(last.dump(-1, ' ', false, Json::error_handler_t::replace)) ? 0 : 1;
}

}  // namespace

Status write_request(const WorkerRequest& request, const std::filesystem::path& folder) {
  const Json json = {{"scene", request.scene},
                     {"files", request.files},
                     {"memory_bytes", request.memory_bytes},
                     {"cpu_seconds", request.cpu_seconds},
                     {"parent", getpid()}};
  LB_RETURN_IF_ERROR(
      write_file(folder / "options.pb", as_bytes(request.options.SerializeAsString())));
  return write_file(folder / "request.json", as_bytes(json.dump()));
}

std::optional<int> run_worker_if_asked(int argc, char** argv, const Engine& engine) {
  if (argc != 3 || std::string_view(argv[1]) != kWorkerArgument) return std::nullopt;
  const int code = work(argv[2], engine);
  // Nothing is left to save: skip the destructors of the libraries in this program.
  std::fflush(nullptr);
  std::_Exit(code);
}

}  // namespace lightbatch::server
