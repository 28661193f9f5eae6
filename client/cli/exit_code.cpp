#include "client/cli/exit_code.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace lightbatch::cli {
namespace {

constexpr int kGrpcCancelled = 1;

/// Reasons that blame the scene or the wish, not the program.
int by_reason(std::string_view reason) {
  static constexpr std::array<std::string_view, 3> kUsage = {"BAD_OPTION", "BAD_REQUEST",
                                                             "JOB_ALREADY_ENDED"};
  static constexpr std::array<std::string_view, 6> kServer = {"DRAINING",      "QUOTA_EXCEEDED",
                                                              "DISK_FULL",     "BLOB_TOO_LARGE",
                                                              "JOB_NOT_FOUND", "SCENE_NOT_FOUND"};
  if (reason.starts_with("INPUT_") || reason == "SCENE_URI_FORBIDDEN" || reason == "BAD_PATH" ||
      reason == "WORKER_OOM") {
    return kSceneRefused;
  }
  if (std::find(kUsage.begin(), kUsage.end(), reason) != kUsage.end()) return kBadUsage;
  if (std::find(kServer.begin(), kServer.end(), reason) != kServer.end()) {
    return kServerUnreachable;
  }
  if (reason == "CANCELLED") return kCancelled;
  return kInternal;
}

}  // namespace

int exit_code(const client::Error& error) {
  if (error.unreachable) return kServerUnreachable;
  if (error.code == kGrpcCancelled) return kCancelled;
  if (error.reason.empty()) return kServerUnreachable;  // refused before the service saw it
  return by_reason(error.reason);
}

int exit_code(const v1::Job& job) {
  switch (job.state()) {
    case v1::JOB_STATE_SUCCEEDED:
      return job.verdict() == v1::VERDICT_MISSED_TARGET ? kMissedTarget : kDone;
    case v1::JOB_STATE_CANCELLED:
      return kCancelled;
    case v1::JOB_STATE_FAILED:
      return by_reason(job.error().detail().reason());
    default:
      return kInternal;
  }
}

}  // namespace lightbatch::cli
