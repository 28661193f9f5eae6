#pragma once

#include "lightbatch/client.h"

namespace lightbatch::cli {

/// Exit codes of the command: promises to scripts.
enum ExitCode : int {
  kDone = 0,
  kBadUsage = 2,
  kSceneRefused = 3,
  kMissedTarget = 4,
  kServerUnreachable = 5,  // or it refused
  kCancelled = 6,
  kInternal = 70,
};

/// For a call that failed.
int exit_code(const client::Error& error);
/// For a job that ended.
int exit_code(const v1::Job& job);

}  // namespace lightbatch::cli
