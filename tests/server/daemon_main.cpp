// A daemon whose jobs are test_engine's: what the tests start, kill and start again.

#include <csignal>

#include "server/config.h"
#include "server/log.h"
#include "server/service.h"
#include "server/worker.h"
#include "tests/server/test_engine.h"

int main(int argc, char** argv) {
  using namespace lightbatch::server;
  if (const auto code = run_worker_if_asked(argc, argv, test::engine())) return *code;
  const ParsedConfig parsed = parse_config(argc, argv, "test build");
  if (parsed.exit_code) return *parsed.exit_code;
  configure_log(parsed.config.log_level, parsed.config.log_json);
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  auto service = Service::start(parsed.config.service, test::engine());
  if (!service.ok()) {
    log_event(LogLevel::kError, "daemon.refused", {{"why", service.status().to_string()}});
    return 1;
  }
  log_event(LogLevel::kInfo, "daemon.ready",
            {{"port", std::to_string((*service)->port())},
             {"admin_port", std::to_string((*service)->admin_port())}});
  int signal = 0;
  sigwait(&set, &signal);
  (*service)->stop();
  log_event(LogLevel::kInfo, "daemon.stopped");
  return 0;
}
