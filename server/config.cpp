#include "server/config.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdint>
#include <map>

namespace lightbatch::server {
namespace {

constexpr const char* kDescription =
    "lightbatchd: takes glTF scenes over gRPC, bakes lightmaps and batches, keeps jobs and files.\n"
    "Stops cleanly on SIGTERM: running jobs go back to the queue and run again after the next "
    "start.";

constexpr std::int64_t kMebi = std::int64_t{1} << 20;
constexpr std::int64_t kMostMebi = std::int64_t{1} << 40;
constexpr int kMost = 1'000'000;
constexpr double kMostSeconds = 1e9;

std::string listen_address(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  int port = -1;
  if (colon != std::string::npos && colon > 0) {
    const char* end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data() + colon + 1, end, port);
    if (parsed.ec != std::errc() || parsed.ptr != end) port = -1;
  }
  const bool good = text.starts_with("unix:") || (port >= 0 && port <= 65535);
  return good ? "" : "'" + text + "' is not HOST:PORT";
}

}  // namespace

ParsedConfig parse_config(int argc, char** argv, const std::string& version) {
  ParsedConfig parsed;
  ServiceConfig& service = parsed.config.service;
  service.data = "/var/lib/lightbatch";
  service.listen = "127.0.0.1:7411";
  service.admin_port = 7412;
  std::int64_t job_memory_mib = 0;
  std::int64_t max_blob_mib = service.blobs.max_blob_bytes / kMebi;
  std::int64_t keep_free_mib = service.blobs.keep_free_bytes / kMebi;
  double keep_days = 0;
  std::int64_t max_store_mib = 0;
  std::string log_format = "text";

  CLI::App app(kDescription, "lightbatchd");
  app.set_version_flag("--version", version);
  app.allow_config_extras(CLI::config_extras_mode::error);
  app.set_config("--config", "", "Read options from this file (TOML: listen = \"127.0.0.1:7411\")");
  const auto option = [&](const char* name, auto& value, const char* help) {
    std::string variable = "LIGHTBATCHD_";
    for (const char* c = name + 2; *c != '\0'; ++c) {
      variable += *c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(*c)));
    }
    return app.add_option(name, value, help)->envname(variable)->capture_default_str();
  };
  option("--data", service.data, "Folder of the job database and the blobs");
  option("--listen", service.listen, "gRPC address, HOST:PORT; port 0 takes a free one")
      ->check(listen_address);
  option("--admin-address", service.admin_address,
         "Address of the admin pages; keep it on loopback");
  option("--admin-port", service.admin_port,
         "Port of /healthz /readyz /metrics /jobs; 0: a free one, -1: none")
      ->check(CLI::Range(-1, 65535));
  option("--tls-cert", service.tls.certificate, "Certificate chain, PEM")->check(CLI::ExistingFile);
  option("--tls-key", service.tls.key, "Private key, PEM")->check(CLI::ExistingFile);
  option("--tls-client-ca", service.tls.client_ca,
         "Demand client certificates of this authority, PEM")
      ->check(CLI::ExistingFile);
  app.add_flag("--insecure", service.insecure, "Allow plain text beyond loopback")
      ->envname("LIGHTBATCHD_INSECURE");
  option("--concurrent-jobs", service.admission.concurrent_jobs,
         "Jobs at the same time; each may use all threads")
      ->check(CLI::Range(1, 1024));
  option("--job-memory", job_memory_mib,
         "Memory limit of one job, MiB; 0: three quarters of the machine, shared by the jobs")
      ->check(CLI::Range(std::int64_t{0}, kMostMebi));
  option("--job-timeout", service.admission.max_job_seconds, "Longest run of one job, seconds")
      ->check(CLI::Range(1.0, kMostSeconds));
  option("--max-queued", service.admission.max_queued_jobs, "Most jobs waiting")
      ->check(CLI::Range(1, kMost));
  option("--max-uploads", service.admission.max_uploads, "Most uploads at the same time")
      ->check(CLI::Range(1, kMost));
  option("--max-watchers", service.admission.max_watchers, "Most watch streams at the same time")
      ->check(CLI::Range(1, kMost));
  option("--max-blob", max_blob_mib, "Largest file, MiB")
      ->check(CLI::Range(std::int64_t{1}, kMostMebi));
  option("--keep-free", keep_free_mib, "Refuse uploads that leave less free disk than this, MiB")
      ->check(CLI::Range(std::int64_t{0}, kMostMebi));
  option("--keep-days", keep_days,
         "Forget ended jobs and unused scenes, and their files, after so many days; 0: never")
      ->check(CLI::Range(0.0, 1e6));
  option("--max-store", max_store_mib,
         "Forget the oldest of them when their files are more than this, MiB; 0: no limit")
      ->check(CLI::Range(std::int64_t{0}, kMostMebi));
  option("--idle-timeout", service.idle_seconds, "End streams that are silent so long, seconds")
      ->check(CLI::Range(0.1, kMostSeconds));
  option("--drain-timeout", service.drain_seconds, "Time for calls in progress on stop, seconds")
      ->check(CLI::Range(0.0, kMostSeconds));
  const std::map<std::string, LogLevel> levels = {{"debug", LogLevel::kDebug},
                                                  {"info", LogLevel::kInfo},
                                                  {"warning", LogLevel::kWarning},
                                                  {"error", LogLevel::kError},
                                                  {"off", LogLevel::kOff}};
  std::string log_level = "info";
  option("--log-level", log_level, "Least level to log: debug, info, warning, error, off")
      ->check(CLI::IsMember(levels, CLI::ignore_case));
  option("--log-format", log_format, "Log lines on stderr: text (key=value) or json")
      ->check(CLI::IsMember({"text", "json"}));
  try {
    app.parse(argc, argv);
    if (service.tls.certificate.empty() != service.tls.key.empty()) {
      throw CLI::ValidationError("--tls-cert and --tls-key go together");
    }
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    parsed.exit_code = code == 0 ? 0 : 2;
    return parsed;
  }
  service.blobs.max_blob_bytes = max_blob_mib * kMebi;
  service.blobs.keep_free_bytes = keep_free_mib * kMebi;
  service.retention.keep_seconds = keep_days * 24 * 3600;
  service.retention.max_bytes = max_store_mib * kMebi;
  service.run.memory_bytes = job_memory_mib > 0
                                 ? job_memory_mib * kMebi
                                 : default_job_memory(service.admission.concurrent_jobs);
  service.run.job_seconds = service.admission.max_job_seconds;
  service.admission.job_memory_bytes = service.run.memory_bytes;
  parsed.config.log_level = levels.at(CLI::detail::to_lower(log_level));
  parsed.config.log_json = log_format == "json";
  return parsed;
}

}  // namespace lightbatch::server
