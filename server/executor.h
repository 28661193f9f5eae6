#pragma once

#include <functional>
#include <memory>

namespace lightbatch::server {

/// Threads for blocking work (disk, database): reactions of gRPC's own threads post here and
/// return. A Boost.Asio thread pool behind a door, so that few files pay for its headers.
class Executor {
 public:
  explicit Executor(int threads);
  ~Executor();  // runs what was posted, then joins
  void post(std::function<void()> work);

 private:
  struct Pool;
  std::unique_ptr<Pool> pool_;
};

}  // namespace lightbatch::server
