#include "core/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

namespace lightbatch {
namespace {

thread_local bool inside_parallel_region = false;

/// One pool per process, made at first use and rebuilt when the number of threads changes. Workers
/// sleep between loops; a loop hands out block indices by one atomic counter.
class Pool {
 public:
  explicit Pool(int threads) {
    for (int i = 1; i < threads; ++i) workers_.emplace_back([this] { work(); });
  }
  ~Pool() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    wake_.notify_all();
  }

  void run(std::size_t blocks, const std::function<void(std::size_t)>& body) {
    {
      const std::lock_guard lock(mutex_);
      body_ = &body;
      blocks_ = blocks;
      next_.store(0, std::memory_order_relaxed);
      running_ = workers_.size();
      ++generation_;
    }
    wake_.notify_all();
    take_blocks(body, blocks);
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return running_ == 0; });
    body_ = nullptr;
  }

 private:
  void take_blocks(const std::function<void(std::size_t)>& body, std::size_t blocks) {
    inside_parallel_region = true;
    for (std::size_t i = next_.fetch_add(1); i < blocks; i = next_.fetch_add(1)) body(i);
    inside_parallel_region = false;
  }

  void work() {
    std::size_t seen = 0;
    std::unique_lock lock(mutex_);
    while (true) {
      wake_.wait(lock, [&] { return stopping_ || generation_ != seen; });
      if (stopping_) return;
      seen = generation_;
      const auto* body = body_;
      const std::size_t blocks = blocks_;
      lock.unlock();
      take_blocks(*body, blocks);
      lock.lock();
      if (--running_ == 0) done_.notify_one();
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_;
  std::condition_variable done_;
  const std::function<void(std::size_t)>* body_ = nullptr;
  std::size_t blocks_ = 0;
  std::atomic<std::size_t> next_{0};
  std::size_t running_ = 0;
  std::size_t generation_ = 0;
  bool stopping_ = false;
  std::vector<std::jthread> workers_;
};

std::mutex pool_mutex;
std::unique_ptr<Pool> pool;
int configured_threads = 0;

int hardware_threads() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void run_blocks(std::size_t blocks, const std::function<void(std::size_t)>& body) {
  if (inside_parallel_region || blocks <= 1 || thread_count() == 1) {
    for (std::size_t i = 0; i < blocks; ++i) body(i);
    return;
  }
  const std::lock_guard lock(pool_mutex);
  if (!pool) pool = std::make_unique<Pool>(thread_count());
  pool->run(blocks, body);
}

}  // namespace

void set_thread_count(int threads) {
  const std::lock_guard lock(pool_mutex);
  const int wanted = std::max(1, threads);
  if (wanted == configured_threads) return;
  configured_threads = wanted;
  pool.reset();
}

int thread_count() { return configured_threads > 0 ? configured_threads : hardware_threads(); }

void parallel_for(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body) {
  if (count == 0) return;
  const std::size_t step = std::max<std::size_t>(1, grain);
  const std::size_t blocks = (count + step - 1) / step;
  run_blocks(blocks, [&](std::size_t block) {
    const std::size_t begin = block * step;
    body(begin, std::min(begin + step, count));
  });
}

}  // namespace lightbatch
