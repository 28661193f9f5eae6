#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "core/base/status.h"
#include "server/blob_store.h"
#include "server/engine.h"
#include "server/job_runner.h"
#include "server/retention.h"
#include "server/services.h"

namespace grpc {
class Channel;
}

namespace lightbatch::server {

/// Files of a TLS endpoint; an empty certificate means plain text.
struct TlsFiles {
  std::filesystem::path certificate;
  std::filesystem::path key;
  std::filesystem::path client_ca;  // not empty: clients must show a certificate of this authority
};

struct ServiceConfig {
  std::filesystem::path data;  // stores and work folder; created
  std::string listen;          // "127.0.0.1:7411", port 0: any; empty: in-process only
  std::string admin_address = "127.0.0.1";
  int admin_port = -1;  // 0: any; -1: no admin pages
  TlsFiles tls;
  bool insecure = false;  // allow plain text beyond loopback
  AdmissionLimits admission;
  BlobLimits blobs;
  RunLimits run;
  Retention retention;
  double idle_seconds = 60;  // a stream with no message for so long is ended
  double drain_seconds = 5;  // for calls in progress when stopping
};

/// The whole service: stores, job threads, gRPC server and admin pages. The daemon runs one with
/// an address; the command line runs one over an in-process channel.
class Service {
 public:
  /// Opens the stores, puts jobs that an earlier process left running back into the queue and
  /// serves. One process per data folder (locked). The program must have called
  /// run_worker_if_asked first.
  static Result<std::unique_ptr<Service>> start(const ServiceConfig& config, const Engine& engine);
  /// stop() if it was not called.
  ~Service();

  /// Health NOT_SERVING; no new jobs; watch streams end UNAVAILABLE; running jobs go back to the
  /// queue; calls in progress get drain_seconds. Blocks until all is down and on disk.
  void stop();
  int port() const;
  int admin_port() const;
  std::shared_ptr<grpc::Channel> in_process_channel();

 private:
  struct Parts;
  explicit Service(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

/// Three quarters of the machine's memory, shared by `concurrent_jobs`.
std::int64_t default_job_memory(int concurrent_jobs);

}  // namespace lightbatch::server
