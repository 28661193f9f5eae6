#pragma once

#include <grpcpp/channel.h>

#include <filesystem>
#include <memory>
#include <string>

#include "lightbatch/client.h"
#include "server/service.h"

namespace lightbatch::server::test {

/// A folder that goes away with its owner.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A service with test_engine's jobs over an in-process channel, and a client of it.
class TestService {
 public:
  explicit TestService(ServiceConfig config = {});
  /// Stops and starts again on the same folder.
  void restart();
  Service& service() { return *service_; }
  client::Client& client() { return *client_; }
  /// Over loopback TCP, as clients elsewhere come.
  std::shared_ptr<grpc::Channel> channel();
  const std::filesystem::path& folder() const { return folder_.path(); }

  /// Uploads a scene of one file with this text and submits a job.
  v1::Job submit(const std::string& text, v1::SubmitJobRequest request = {});
  /// submit and watch to the end.
  v1::Job run(const std::string& text, v1::SubmitJobRequest request = {});
  std::string scene(const std::string& text);
  /// Waits until the job is in this state (or ended); the job as it is then.
  v1::Job wait_for(const std::string& name, v1::JobState state);

 private:
  TemporaryFolder folder_;
  ServiceConfig config_;
  std::unique_ptr<Service> service_;
  std::unique_ptr<client::Client> client_;
};

v1::Digest digest_of(const std::string& bytes);

}  // namespace lightbatch::server::test
