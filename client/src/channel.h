#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <thread>

#include "lightbatch/client.h"
#include "lightbatch/v1/blob_service.grpc.pb.h"
#include "lightbatch/v1/capability_service.grpc.pb.h"
#include "lightbatch/v1/job_service.grpc.pb.h"
#include "lightbatch/v1/scene_service.grpc.pb.h"

namespace lightbatch::client {

/// Stubs of one channel and the rule of when to try again.
struct Client::Calls {
  std::unique_ptr<v1::BlobService::Stub> blobs;
  std::unique_ptr<v1::SceneService::Stub> scenes;
  std::unique_ptr<v1::JobService::Stub> jobs;
  std::unique_ptr<v1::CapabilityService::Stub> capabilities;
  std::shared_ptr<grpc::Channel> channel;
  double patience = 60;
};

/// gRPC's status with the ErrorDetail of its trailer.
Error to_error(const grpc::Status& status);

/// Waits between tries: doubling from 50 ms to 2 s, until patience is used up.
class Retry {
 public:
  explicit Retry(double patience)
      : end_(std::chrono::steady_clock::now() + std::chrono::duration<double>(patience)) {}
  /// False when there is no time left.
  bool wait() {
    if (std::chrono::steady_clock::now() + delay_ > end_) return false;
    std::this_thread::sleep_for(delay_);
    delay_ = std::min(delay_ * 2, std::chrono::duration<double>(2.0));
    return true;
  }
  /// After progress: as if nothing had happened.
  void restart(double patience) {
    end_ = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience);
    delay_ = std::chrono::duration<double>(0.05);
  }

 private:
  using Time = std::chrono::time_point<std::chrono::steady_clock, std::chrono::duration<double>>;
  Time end_;
  std::chrono::duration<double> delay_{0.05};
};

/// Calls that reach a server while it stops end as cancelled, without an ErrorDetail of its own.
inline bool may_retry(const grpc::Status& status) {
  return status.error_code() == grpc::StatusCode::UNAVAILABLE ||
         (status.error_code() == grpc::StatusCode::CANCELLED && status.error_details().empty());
}

/// One unary call, again while the server is unavailable. call(context, response) -> status.
template <typename Response>
Outcome<Response> unary(double patience,
                        const std::function<grpc::Status(grpc::ClientContext*, Response*)>& call) {
  for (Retry retry(patience);;) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(60));
    Response response;
    const grpc::Status status = call(&context, &response);
    if (status.ok()) return response;
    if (!may_retry(status) || !retry.wait()) return to_error(status);
  }
}

}  // namespace lightbatch::client
