#include <gtest/gtest.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/asio/write.hpp>
#include <csignal>
#include <cstdlib>

#include "tests/server/test_service.h"

namespace lightbatch::server::test {
namespace {

std::string failure(const v1::Job& job) {
  return job.state() == v1::JOB_STATE_FAILED ? job.error().detail().reason()
                                             : v1::JobState_Name(job.state());
}

TEST(Worker, ACrashFailsItsOwnJobOnly) {
  TestService service;
  const v1::Job crashed = service.run("crash");
  EXPECT_EQ(failure(crashed), "WORKER_CRASHED");
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_EQ(crashed.error().detail().metadata().at("signal"), std::to_string(SIGSEGV));
#endif
  EXPECT_EQ(failure(service.run("abort")), "WORKER_CRASHED");
  EXPECT_EQ(failure(service.run("exit")), "WORKER_CRASHED");
  EXPECT_EQ(service.run("ok").state(), v1::JOB_STATE_SUCCEEDED);
}

TEST(Worker, RunningOutOfMemoryHasItsReason) {
  TestService service;
  const v1::Job job = service.run("oom");
  EXPECT_EQ(failure(job), "WORKER_OOM");
  EXPECT_LT(job.peak_memory_bytes(), std::int64_t{600} << 20);
  EXPECT_EQ(failure(service.run("oom-thread")), "WORKER_OOM");
  EXPECT_EQ(service.run("ok").state(), v1::JOB_STATE_SUCCEEDED);
}

TEST(Worker, TimeIsLimited) {
  TestService service;
  v1::SubmitJobRequest request;
  request.mutable_timeout()->set_nanos(300'000'000);
  EXPECT_EQ(failure(service.run("deaf", request)), "TIMEOUT");
  EXPECT_EQ(failure(service.run("slow", request)), "TIMEOUT");
}

TEST(Worker, AFaultOfTheSceneKeepsItsPlace) {
  TestService service;
  const v1::Job job = service.run("malformed");
  EXPECT_EQ(failure(job), "INPUT_MALFORMED");
  EXPECT_EQ(job.error().detail().place(), "scene.gltf#/nodes/3");
  EXPECT_EQ(job.error().code(), 3);
  EXPECT_EQ(job.artifacts_size(), 0);
}

TEST(Worker, IsLockedIn) {
  setenv("LIGHTBATCH_SECRET", "not for children", 1);
  TestService service;
  const v1::Job job = service.run("limits");
  ASSERT_EQ(job.state(), v1::JOB_STATE_SUCCEEDED) << job.error().message();
  const std::string text = *service.client().read_blob(job.artifacts(1).digest());
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_NE(text.find("memory=" + std::to_string(std::int64_t{512} << 20)), std::string::npos)
      << text;
  EXPECT_NE(text.find(" network=0 programs=0 environment="), std::string::npos) << text;
  EXPECT_TRUE(text.ends_with("environment=")) << text;
#endif
  EXPECT_NE(text.find("core=0 cpu_limited=1 no_new_privs=1 extra_files=0 "), std::string::npos)
      << text;
  EXPECT_EQ(text.find("SECRET"), std::string::npos);
}

/// One request to the admin port: the whole answer.
std::string http(int port, const std::string& request) {
  boost::asio::io_context io;
  boost::asio::ip::tcp::socket socket(io);
  socket.connect({boost::asio::ip::address_v4::loopback(), static_cast<std::uint16_t>(port)});
  boost::asio::write(socket, boost::asio::buffer(request));
  std::string answer;
  boost::system::error_code error;
  boost::asio::read(socket, boost::asio::dynamic_buffer(answer), error);
  return answer;
}

TEST(Admin, ServesHealthMetricsAndPages) {
  ServiceConfig config;
  config.admin_port = 0;
  TestService service(config);
  const v1::Job job = service.run("ok");
  const int port = service.service().admin_port();
  const auto get = [&](const std::string& path) {
    return http(port, "GET " + path + " HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
  };
  EXPECT_NE(get("/healthz").find("200 OK"), std::string::npos);
  EXPECT_NE(get("/readyz").find("200 OK"), std::string::npos);
  const std::string metrics = get("/metrics");
  EXPECT_NE(metrics.find("lightbatch_jobs{state=\"succeeded\"} 1"), std::string::npos) << metrics;
  EXPECT_NE(metrics.find("lightbatch_job_seconds_count 1"), std::string::npos);
  EXPECT_NE(get("/jobs").find(job.name().substr(5)), std::string::npos);
  const std::string report = get("/" + job.name() + "/report");
  EXPECT_NE(report.find("<p>report of a test"), std::string::npos) << report;
  EXPECT_NE(report.find("Content-Security-Policy"), std::string::npos);
  EXPECT_NE(get("/" + job.name() + "/none").find("404"), std::string::npos);
  EXPECT_NE(get("/../etc/passwd").find("404"), std::string::npos);
  EXPECT_NE(http(port, "POST / HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n").find("405"),
            std::string::npos);
  EXPECT_NE(http(port, "POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 2\r\n\r\nhi").find("405"),
            std::string::npos);
  const std::string head =
      http(port, "HEAD /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
  EXPECT_NE(head.find("Content-Length: 3\r\n"), std::string::npos) << head;
  EXPECT_TRUE(head.ends_with("\r\n\r\n")) << head;
}

TEST(Admin, IsNotReadyOnAFullDisk) {
  ServiceConfig config;
  config.admin_port = 0;
  config.blobs.keep_free_bytes = std::int64_t{1} << 60;
  TestService service(config);
  const int port = service.service().admin_port();
  EXPECT_NE(http(port, "GET /readyz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n").find("503"),
            std::string::npos);
}

TEST(Start, RefusesWhatIsNotSafe) {
  TemporaryFolder folder;
  ServiceConfig config;
  config.data = folder.path() / "data";
  config.listen = "0.0.0.0:0";
  const Engine engine = {nullptr, nullptr, nullptr};
  EXPECT_EQ(Service::start(config, engine).status().reason(), "TLS_REQUIRED");
  config.insecure = true;
  const auto service = Service::start(config, engine);
  ASSERT_TRUE(service.ok());
  EXPECT_GT((*service)->port(), 0);
  // One process per folder, one server per port.
  EXPECT_EQ(Service::start(config, engine).status().reason(), "DATA_IN_USE");
  config.data = folder.path() / "other";
  config.listen = "127.0.0.1:" + std::to_string((*service)->port());
  EXPECT_EQ(Service::start(config, engine).status().reason(), "ADDRESS_TAKEN");
}

}  // namespace
}  // namespace lightbatch::server::test
