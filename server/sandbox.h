#pragma once

#include <sys/types.h>

#include <cstdint>

namespace lightbatch::server {

struct SandboxLimits {
  std::int64_t memory_bytes = 0;  // address space; 0: not limited
  std::int64_t cpu_seconds = 0;   // of all threads; 0: not limited
  pid_t parent = 0;               // the process dies with this one
  int highest_descriptor = 2;     // descriptors above are closed
};

/// Gives up what a worker does not need, before it looks at the first byte of a scene: dies with
/// its parent, no new privileges, no core files, limits on memory and processor time, and a
/// system-call filter without network, other programs and other processes. Cannot be undone.
/// Sanitizer builds reserve terabytes of shadow memory and start a symbolizer: they go without the
/// memory limit and the filter.
void enter_sandbox(const SandboxLimits& limits);

}  // namespace lightbatch::server
