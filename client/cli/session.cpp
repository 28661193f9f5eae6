#include "client/cli/session.h"

#include <pthread.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "client/cli/exit_code.h"
#include "core/pipeline/job.h"
#include "server/log.h"
#include "server/service.h"

namespace lightbatch::cli {
namespace {

constexpr double kFirstCallPatience = 5;  // seconds: a wrong address should not take a minute
constexpr double kLaterPatience = 120;    // a restart of the daemon is no reason to give up

sigset_t handled_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGUSR2);  // wakes the thread at the end
  return set;
}

client::Error local_error(const Status& status) {
  client::Error error;
  error.code = static_cast<int>(status.code());
  error.reason = status.reason();
  error.message = status.message();
  error.place = status.place();
  return error;
}

std::string file_text(const std::string& file) {
  if (file.empty()) return {};
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

Result<std::filesystem::path> temporary_folder() {
  std::error_code error;
  std::string pattern =
      (std::filesystem::temp_directory_path(error) / "lightbatch-XXXXXX").string();
  if (error || mkdtemp(pattern.data()) == nullptr) {
    return io_error(pattern, "cannot make a temporary folder; set TMPDIR or give --data-dir");
  }
  return std::filesystem::path(pattern);
}

}  // namespace

void block_signals() {
  const sigset_t set = handled_signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

client::Outcome<std::unique_ptr<Session>> Session::open(const ServerOptions& options) {
  std::unique_ptr<Session> session(new Session());
  if (options.address.empty()) {
    server::configure_log(server::LogLevel::kError, false);
    server::ServiceConfig config;
    config.data = options.data;
    if (config.data.empty()) {
      const auto folder = temporary_folder();
      if (!folder.ok()) return local_error(folder.status());
      session->temporary_ = config.data = *folder;
    }
    config.run.memory_bytes =
        options.job_memory_mib > 0 ? options.job_memory_mib << 20 : server::default_job_memory(1);
    config.admission.job_memory_bytes = config.run.memory_bytes;
    auto service =
        server::Service::start(config, {pipeline::run_job, pipeline::validate, pipeline::build_id});
    if (!service.ok()) return local_error(service.status());
    session->service_ = std::move(service).value();
    session->client_ = client::Client::over(session->service_->in_process_channel());
  } else if (options.tls_ca.empty() && options.tls_cert.empty()) {
    session->client_ = client::Client::connect(options.address);
  } else {
    session->client_ = client::Client::connect(
        options.address,
        {file_text(options.tls_ca), file_text(options.tls_cert), file_text(options.tls_key)});
  }
  session->client_->set_patience(kFirstCallPatience);
  const auto reached = session->client_->capabilities();
  if (!reached.ok()) return reached.error();
  session->client_->set_patience(kLaterPatience);
  session->signals_ = std::thread([raw = session.get()] { raw->wait_for_signals(); });
  return session;
}

Session::~Session() {
  closing_ = true;
  if (signals_.joinable()) {
    pthread_kill(signals_.native_handle(), SIGUSR2);
    signals_.join();
  }
  if (canceller_.joinable()) canceller_.join();
  service_.reset();
  if (!temporary_.empty()) {
    std::error_code ignored;
    std::filesystem::remove_all(temporary_, ignored);
  }
}

void Session::set_job(const std::string& name) {
  const std::lock_guard lock(mutex_);
  job_ = name;
}

void Session::wait_for_signals() {
  const sigset_t set = handled_signals();
  for (int signal = 0; !closing_;) {
    sigwait(&set, &signal);
    if (closing_ || signal == SIGUSR2) continue;
    std::string job;
    {
      const std::lock_guard lock(mutex_);
      job = job_;
    }
    if (interrupted_.exchange(true)) {
      // The worker dies with this process; only the temporary folder needs a hand.
      std::error_code ignored;
      if (!temporary_.empty()) std::filesystem::remove_all(temporary_, ignored);
      std::_Exit(kCancelled);
    }
    std::fprintf(stderr, "\ncancelling; press Ctrl-C again to leave at once\n");
    if (!job.empty()) {
      canceller_ = std::thread([this, job] { static_cast<void>(client_->cancel(job)); });
    }
  }
}

}  // namespace lightbatch::cli
