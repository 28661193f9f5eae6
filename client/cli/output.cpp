#include "client/cli/output.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdio>

#include "client/cli/exit_code.h"

namespace lightbatch::cli {
namespace {

using Json = nlohmann::json;

double to_seconds(const google::protobuf::Timestamp& time) {
  return static_cast<double>(time.seconds()) + time.nanos() * 1e-9;
}

}  // namespace

int report_error(const client::Error& error, bool json) {
  const int code = exit_code(error);
  std::fprintf(stderr, "lightbatch: %s\n",
               error.unreachable ? ("cannot reach the server: " + error.message).c_str()
                                 : error.to_string().c_str());
  if (json) {
    const Json text = {{"error",
                        {{"code", error.code},
                         {"reason", error.reason},
                         {"message", error.message},
                         {"place", error.place}}}};
    std::printf("%s\n", text.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
  }
  return code;
}

int usage_error(const std::string& message) {
  std::fprintf(stderr, "lightbatch: %s\nRun with --help for more.\n", message.c_str());
  return kBadUsage;
}

std::string state_word(v1::JobState state) {
  return v1::JobState_Name(state).substr(sizeof("JOB_STATE_") - 1);
}

std::string kind_word(v1::JobKind kind) {
  std::string word = v1::JobKind_Name(kind).substr(sizeof("JOB_KIND_") - 1);
  std::transform(word.begin(), word.end(), word.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return kind == v1::JOB_KIND_UNSPECIFIED ? "bake" : word;
}

double run_seconds(const v1::Job& job) {
  if (!job.has_start_time()) return 0;
  const std::chrono::duration<double> now = std::chrono::system_clock::now().time_since_epoch();
  const double end = job.has_end_time() ? to_seconds(job.end_time()) : now.count();
  return std::max(0.0, end - to_seconds(job.start_time()));
}

std::string job_name(const std::string& typed) {
  return typed.starts_with("jobs/") ? typed : "jobs/" + typed;
}

Json job_json(const v1::Job& job) {
  Json out = {{"job", job.name()},           {"kind", kind_word(job.options().kind())},
              {"scene", job.scene()},        {"state", state_word(job.state())},
              {"attempt", job.attempt()},    {"cache_hit", job.cache_hit()},
              {"seconds", run_seconds(job)}, {"peak_memory_bytes", job.peak_memory_bytes()}};
  if (!job.display_name().empty()) out["name"] = job.display_name();
  if (job.has_progress()) {
    out["phase"] = job.progress().phase();
    out["fraction"] = job.progress().fraction();
  }
  if (job.state() == v1::JOB_STATE_SUCCEEDED) {
    out["verdict"] = job.verdict() == v1::VERDICT_MISSED_TARGET ? "MISSED_TARGET" : "DONE";
    out["summary"] = job.summary();
    out["artifacts"] = Json::array();
    for (const v1::Artifact& artifact : job.artifacts()) {
      out["artifacts"].push_back({{"path", artifact.path()},
                                  {"size_bytes", artifact.digest().size_bytes()},
                                  {"sha256", artifact.digest().sha256()}});
    }
  }
  if (job.has_error()) {
    out["error"] = {{"code", job.error().code()},
                    {"reason", job.error().detail().reason()},
                    {"message", job.error().message()},
                    {"place", job.error().detail().place()}};
  }
  return out;
}

}  // namespace lightbatch::cli
