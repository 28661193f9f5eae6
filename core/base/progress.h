#pragma once

#include <atomic>
#include <functional>
#include <string_view>

namespace lightbatch {

/// How a long stage tells what it does and hears that it should stop. Stages call report() and
/// check cancelled() at least every 50 ms of work, from the thread that runs the stage.
/// The callback is called on that thread; it must be quick. Default: silent, never cancelled.
class Progress {
 public:
  /// phase: a short lower-case word ("gather"); fraction of that phase in [0, 1].
  using Callback = std::function<void(std::string_view phase, double fraction)>;

  Progress() = default;
  Progress(Callback callback, const std::atomic<bool>* cancel)
      : callback_(std::move(callback)), cancel_(cancel) {}

  void report(std::string_view phase, double fraction) const {
    if (callback_) callback_(phase, fraction);
  }
  bool cancelled() const { return cancel_ != nullptr && cancel_->load(std::memory_order_relaxed); }

 private:
  Callback callback_;
  const std::atomic<bool>* cancel_ = nullptr;
};

}  // namespace lightbatch
