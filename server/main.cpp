// lightbatchd: the daemon. Start order: worker door, options, log, service, signals. Stop order:
// see Service::stop.

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <csignal>
#include <cstdlib>
#include <thread>

#include "core/pipeline/job.h"
#include "server/config.h"
#include "server/log.h"
#include "server/service.h"
#include "server/worker.h"

namespace {

using namespace lightbatch;
using namespace lightbatch::server;

/// A stop that hangs must not keep the machine from restarting the daemon: everything durable is
/// durable already.
void stop_with_watchdog(Service& service, double drain_seconds) {
  boost::asio::io_context io;
  boost::asio::steady_timer timer(io, std::chrono::seconds(15 + static_cast<int>(drain_seconds)));
  timer.async_wait([](const boost::system::error_code& error) {
    if (!error) {
      log_event(LogLevel::kError, "daemon.stop_hangs");
      std::_Exit(1);
    }
  });
  std::thread watchdog([&] { io.run(); });
  service.stop();
  boost::asio::post(io, [&] { timer.cancel(); });
  watchdog.join();
}

}  // namespace

int main(int argc, char** argv) {
  const Engine engine = {pipeline::run_job, pipeline::validate, pipeline::build_id};
  if (const auto code = run_worker_if_asked(argc, argv, engine)) return *code;
  const ParsedConfig parsed = parse_config(argc, argv, pipeline::build_id());
  if (parsed.exit_code) return *parsed.exit_code;
  // What goes wrong in gRPC comes back as a status; its own lines are in another form than ours.
  setenv("GRPC_VERBOSITY", "NONE", 0);
  configure_log(parsed.config.log_level, parsed.config.log_json);

  boost::asio::io_context io;
  boost::asio::signal_set signals(io, SIGTERM, SIGINT);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGHUP, SIG_IGN);
  auto service = Service::start(parsed.config.service, engine);
  if (!service.ok()) {
    log_event(LogLevel::kError, "daemon.refused", {{"why", service.status().to_string()}});
    return service.status().code() == StatusCode::kInvalidArgument ? 2 : 1;
  }
  log_event(LogLevel::kInfo, "daemon.ready",
            {{"port", std::to_string((*service)->port())},
             {"admin_port", std::to_string((*service)->admin_port())},
             {"data", parsed.config.service.data.string()},
             {"build", pipeline::build_id()}});
  signals.async_wait([&](const boost::system::error_code&, int signal) {
    log_event(LogLevel::kInfo, "daemon.stopping", {{"signal", std::to_string(signal)}});
  });
  io.run();
  stop_with_watchdog(**service, parsed.config.service.drain_seconds);
  log_event(LogLevel::kInfo, "daemon.stopped");
  return 0;
}
