#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "core/base/status.h"

namespace lightbatch::server {

/// How a child ended.
struct ChildExit {
  int code = 0;                        // exit code; meaningless when signal is set
  int signal = 0;                      // 0: it exited by itself
  std::int64_t peak_memory_bytes = 0;  // resident
};

/// What the parent asks of a running child.
enum class ChildOrder { kGoOn, kStop, kKill };

/// Runs this very executable again as a worker on `folder` and waits for its end on this thread.
/// posix_spawn, never fork: gRPC's threads do not survive a fork. The child gets its own process
/// group, default signals and an environment with nothing in it but sanitizer settings.
///
/// on_frame gets each frame's bytes; a frame longer than kMaxFrameBytes kills the child.
/// orders is asked at least every 100 ms; kStop sends SIGTERM once, and SIGKILL `grace_seconds`
/// later; kKill sends SIGKILL.
Result<ChildExit> run_child(const std::filesystem::path& folder, double grace_seconds,
                            const std::function<void(std::string_view)>& on_frame,
                            const std::function<ChildOrder()>& orders);

}  // namespace lightbatch::server
