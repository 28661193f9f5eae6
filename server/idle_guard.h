#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <vector>

namespace lightbatch::server {

/// Ends streams whose peer fell silent. A stream enters with a way to cancel it, touches the guard
/// with each message and leaves before it is destroyed; sweep() cancels the silent ones.
/// Thread-safe.
class IdleGuard {
 public:
  using Clock = std::chrono::steady_clock;

  std::uint64_t enter(std::function<void()> cancel) {
    const std::lock_guard lock(mutex_);
    streams_[next_] = {std::move(cancel), Clock::now()};
    return next_++;
  }
  void touch(std::uint64_t stream) {
    const std::lock_guard lock(mutex_);
    if (const auto found = streams_.find(stream); found != streams_.end()) {
      found->second.last = Clock::now();
    }
  }
  void leave(std::uint64_t stream) {
    const std::lock_guard lock(mutex_);
    streams_.erase(stream);
  }
  void sweep(std::chrono::duration<double> longest) {
    const std::lock_guard lock(mutex_);
    std::vector<std::uint64_t> silent;
    for (const auto& [id, stream] : streams_) {
      if (Clock::now() - stream.last > longest) silent.push_back(id);
    }
    for (const std::uint64_t id : silent) {
      const auto found = streams_.find(id);
      if (found == streams_.end()) continue;
      // A cancelled stream may leave from inside this call.
      const auto cancel = found->second.cancel;
      cancel();
    }
  }

 private:
  struct Stream {
    std::function<void()> cancel;
    Clock::time_point last;
  };
  std::recursive_mutex mutex_;
  std::map<std::uint64_t, Stream> streams_;
  std::uint64_t next_ = 1;
};

}  // namespace lightbatch::server
