#include "server/executor.h"

#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>

namespace lightbatch::server {

struct Executor::Pool {
  explicit Pool(std::size_t count) : threads(count) {}
  boost::asio::thread_pool threads;
};

Executor::Executor(int threads)
    : pool_(std::make_unique<Pool>(static_cast<std::size_t>(threads))) {}

Executor::~Executor() { pool_->threads.join(); }

void Executor::post(std::function<void()> work) {
  boost::asio::post(pool_->threads, std::move(work));
}

}  // namespace lightbatch::server
