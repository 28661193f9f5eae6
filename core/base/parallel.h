#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <utility>
#include <vector>

namespace lightbatch {

/// Threads of the whole core live here and nowhere else. The number of threads is a property of
/// the process (one job per process): set once before work starts.
///
/// Every primitive gives results that do not depend on the number of threads: work is cut into
/// blocks of a fixed grain, each block writes its own place, and reductions are folded in block
/// order.
void set_thread_count(int threads);
/// At least 1. Default: the number of hardware threads.
int thread_count();

/// Calls body(begin, end) for consecutive blocks of [0, count) of at most `grain` items, on up to
/// thread_count() threads; the caller's thread works too. Blocks may run in any order. body must
/// not throw. Nested calls run serially on the thread that makes them.
void parallel_for(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

/// Works through `open`, the largest (operator<) first, and through what that brings up, on up to
/// thread_count() threads (nested calls: serially). make_body() gives each thread a body of its
/// own; body(task, more) appends the tasks that are to follow. body must not throw.
template <typename Task, typename MakeBody>
void parallel_tasks(std::vector<Task> open, MakeBody make_body) {
  std::mutex mutex;
  std::condition_variable changed;
  std::size_t running = 0;
  std::make_heap(open.begin(), open.end());
  const auto work = [&] {
    auto body = make_body();
    std::vector<Task> more;
    std::unique_lock lock(mutex);
    while (true) {
      changed.wait(lock, [&] { return !open.empty() || running == 0; });
      if (open.empty()) return;
      std::pop_heap(open.begin(), open.end());
      const Task task = std::move(open.back());
      open.pop_back();
      ++running;
      lock.unlock();
      more.clear();
      body(task, more);
      lock.lock();
      --running;
      for (Task& one : more) {
        open.push_back(std::move(one));
        std::push_heap(open.begin(), open.end());
      }
      if (!more.empty() || (open.empty() && running == 0)) changed.notify_all();
    }
  };
  parallel_for(static_cast<std::size_t>(thread_count()), 1,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t i = begin; i < end; ++i) work();
               });
}

/// Maps each block of `grain` items to a T by map(begin, end) and folds the blocks in order:
/// fold(fold(initial, block 0), block 1)... The same bits on any number of threads.
template <typename T, typename Map, typename Fold>
T deterministic_reduce(std::size_t count, std::size_t grain, T initial, Map map, Fold fold) {
  if (count == 0) return initial;
  const std::size_t blocks = (count + grain - 1) / grain;
  std::vector<T> partial(blocks, initial);
  parallel_for(blocks, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t block = first; block < last; ++block) {
      const std::size_t begin = block * grain;
      const std::size_t end = begin + grain < count ? begin + grain : count;
      partial[block] = map(begin, end);
    }
  });
  T total = std::move(initial);
  for (T& value : partial) total = fold(std::move(total), std::move(value));
  return total;
}

}  // namespace lightbatch
