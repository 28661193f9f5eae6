#include "tests/server/test_service.h"

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

#include <cstdlib>
#include <fstream>

#include "core/base/bytes.h"
#include "core/base/hash.h"
#include "tests/server/test_engine.h"

namespace lightbatch::server::test {

TemporaryFolder::TemporaryFolder() {
  std::string pattern =
      (std::filesystem::temp_directory_path() / "lightbatch-test-XXXXXX").string();
  LB_CHECK(mkdtemp(pattern.data()) != nullptr, "a temporary folder");
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

TestService::TestService(ServiceConfig config) : config_(std::move(config)) {
  config_.data = folder_.path() / "data";
  config_.listen = "127.0.0.1:0";
  config_.drain_seconds = 1;
  if (config_.run.memory_bytes == 0) config_.run.memory_bytes = std::int64_t{512} << 20;
  config_.run.cancel_grace_seconds = 0.3;
  restart();
}

void TestService::restart() {
  client_.reset();
  service_.reset();
  auto started = Service::start(config_, engine());
  LB_CHECK(started.ok(), started.ok() ? "" : started.status().to_string().c_str());
  service_ = std::move(started).value();
  client_ = client::Client::over(service_->in_process_channel());
  client_->set_patience(2);
}

std::shared_ptr<grpc::Channel> TestService::channel() {
  return grpc::CreateChannel("127.0.0.1:" + std::to_string(service_->port()),
                             grpc::InsecureChannelCredentials());
}

std::string TestService::scene(const std::string& text) {
  const auto file = folder_.path() / "scene.gltf";
  std::ofstream(file) << text;
  const auto scene = client_->upload_files("scene.gltf", {{"scene.gltf", file}});
  LB_CHECK(scene.ok(), scene.ok() ? "" : scene.error().to_string().c_str());
  return scene->name();
}

v1::Job TestService::submit(const std::string& text, v1::SubmitJobRequest request) {
  request.set_scene(scene(text));
  const auto job = client_->submit(request);
  LB_CHECK(job.ok(), job.ok() ? "" : job.error().to_string().c_str());
  return *job;
}

v1::Job TestService::run(const std::string& text, v1::SubmitJobRequest request) {
  const v1::Job job = submit(text, std::move(request));
  const auto ended = client_->watch(job.name(), [](const v1::Job&) { return true; });
  LB_CHECK(ended.ok(), ended.ok() ? "" : ended.error().to_string().c_str());
  return *ended;
}

v1::Job TestService::wait_for(const std::string& name, v1::JobState state) {
  const auto job = client_->watch(name, [&](const v1::Job& now) { return now.state() != state; });
  LB_CHECK(job.ok(), job.ok() ? "" : job.error().to_string().c_str());
  return *job;
}

v1::Digest digest_of(const std::string& bytes) {
  v1::Digest digest;
  digest.set_sha256(sha256_hex(as_bytes(bytes)));
  digest.set_size_bytes(static_cast<std::int64_t>(bytes.size()));
  return digest;
}

}  // namespace lightbatch::server::test
