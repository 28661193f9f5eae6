#pragma once

namespace lightbatch::internal {
/// Prints the broken invariant to stderr and aborts.
[[noreturn]] void check_failed(const char* file, int line, const char* condition,
                               const char* message);
}  // namespace lightbatch::internal

/// Broken invariants abort, in every build. Never reachable from a file or a request.
#define LB_CHECK(condition, message)                                                         \
  do {                                                                                       \
    if (!(condition)) [[unlikely]]                                                           \
      ::lightbatch::internal::check_failed(__FILE__, __LINE__, #condition, message);         \
  } while (false)

/// The same for inner loops: checked in debug and sanitizer builds only.
#ifdef NDEBUG
#define LB_DCHECK(condition, message) static_cast<void>(0)
#else
#define LB_DCHECK(condition, message) LB_CHECK(condition, message)
#endif
