#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "lightbatch/client.h"

namespace lightbatch::server {
class Service;
}

namespace lightbatch::cli {

/// Where the service is.
struct ServerOptions {
  std::string address;              // empty: inside this process
  std::filesystem::path data;       // of the inner service; empty: temporary
  std::int64_t job_memory_mib = 0;  // of the inner service
  std::string tls_ca;               // files; any of them turns TLS on
  std::string tls_cert;
  std::string tls_key;
};

/// A client and, without an address, the whole service behind an in-process channel: the same code
/// path without a daemon. Owns the handling of Ctrl-C: the first cancels the job at hand, the
/// second leaves the program.
class Session {
 public:
  /// Reaches the server once; an Error when it cannot.
  static client::Outcome<std::unique_ptr<Session>> open(const ServerOptions& options);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  client::Client& client() { return *client_; }
  /// True once the user asked to stop.
  bool interrupted() const { return interrupted_; }
  /// The job that Ctrl-C cancels from now on; empty: none.
  void set_job(const std::string& name);

 private:
  Session() = default;
  void wait_for_signals();

  std::unique_ptr<server::Service> service_;
  std::filesystem::path temporary_;
  std::unique_ptr<client::Client> client_;
  std::atomic<bool> interrupted_ = false;
  std::atomic<bool> closing_ = false;
  std::mutex mutex_;
  std::string job_;
  std::thread signals_;
  std::thread canceller_;  // so that a second Ctrl-C is heard meanwhile
};

/// Call first in main: signals are taken by a thread of the session alone.
void block_signals();

}  // namespace lightbatch::cli
