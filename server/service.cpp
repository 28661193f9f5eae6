#include "server/service.h"

#include <fcntl.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include "core/base/bytes.h"
#include "server/admin_pages.h"
#include "server/database.h"
#include "server/log.h"
#include "server/timestamps.h"

namespace lightbatch::server {
namespace {

constexpr int kExecutorThreads = 8;
constexpr std::size_t kCallMemory = std::size_t{64} << 20;  // soft: what streams may buffer
constexpr int kStreamsPerConnection = 512;
constexpr std::int64_t kUploadAgeUs = 7LL * 24 * 3600 * 1'000'000;
constexpr auto kCollectInterval = std::chrono::hours(1);
constexpr const char* kServiceNames[] = {"", "lightbatch.v1.BlobService",
                                         "lightbatch.v1.SceneService", "lightbatch.v1.JobService",
                                         "lightbatch.v1.CapabilityService"};

bool is_loopback(const std::string& listen) {
  const std::string host = listen.substr(0, listen.rfind(':'));
  return host == "localhost" || host == "[::1]" || host.starts_with("127.");
}

Result<std::shared_ptr<grpc::ServerCredentials>> credentials(const ServiceConfig& config) {
  if (config.tls.certificate.empty()) {
    if (!config.insecure && !config.listen.starts_with("unix:") && !is_loopback(config.listen)) {
      return Status(StatusCode::kInvalidArgument, "TLS_REQUIRED",
                    "refusing to listen beyond loopback in plain text; give a certificate and key "
                    "(--tls-cert, --tls-key), or --insecure on a network you trust",
                    config.listen);
    }
    return grpc::InsecureServerCredentials();
  }
  LB_ASSIGN_OR_RETURN(const Bytes certificate, read_file(config.tls.certificate));
  LB_ASSIGN_OR_RETURN(const Bytes key, read_file(config.tls.key));
  grpc::SslServerCredentialsOptions options(
      config.tls.client_ca.empty() ? GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE
                                   : GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  options.pem_key_cert_pairs.push_back(
      {std::string(as_text(key)), std::string(as_text(certificate))});
  if (!config.tls.client_ca.empty()) {
    LB_ASSIGN_OR_RETURN(const Bytes authority, read_file(config.tls.client_ca));
    options.pem_root_certs = std::string(as_text(authority));
  }
  return grpc::SslServerCredentials(options);
}

Result<int> lock_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return io_error(folder.string(), "cannot create the data folder: " + error.message());
  const int fd = ::open((folder / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (fd < 0) return io_error(folder.string(), "cannot write in the data folder");
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    ::close(fd);
    return Status(StatusCode::kFailedPrecondition, "DATA_IN_USE",
                  "another process serves this data folder", folder.string());
  }
  return fd;
}

}  // namespace

struct Service::Parts {
  ServiceConfig config;
  Engine engine;
  int lock = -1;
  std::unique_ptr<Database> database;
  std::unique_ptr<BlobStore> blobs;
  std::unique_ptr<SceneStore> scenes;
  std::unique_ptr<JobStore> jobs;
  std::unique_ptr<JobBoard> board;
  std::unique_ptr<JobRunner> runner;
  Metrics metrics;
  IdleGuard idle;
  std::unique_ptr<Executor> executor;
  std::unique_ptr<ServiceContext> context;
  std::vector<std::unique_ptr<grpc::Service>> services;
  std::unique_ptr<grpc::Server> server;
  std::unique_ptr<AdminHttp> admin;
  std::vector<std::thread> job_threads;
  std::thread sweeper;
  std::mutex stop_mutex;
  std::condition_variable stop_changed;
  bool stopped = false;
  int port = 0;

  ~Parts() {
    if (lock >= 0) ::close(lock);
  }
  Status open_stores();
  Status serve();
  void run_jobs();
  void run_job(const JobBoard::Claim& claim);
  void sweep();
  void collect_old();
};

Status Service::Parts::open_stores() {
  LB_ASSIGN_OR_RETURN(lock, lock_folder(config.data));
  LB_ASSIGN_OR_RETURN(database, Database::open(config.data / "lightbatch.db"));
  LB_ASSIGN_OR_RETURN(blobs, BlobStore::open(config.data, *database, config.blobs));
  LB_RETURN_IF_ERROR(blobs->sweep_uploads(kUploadAgeUs));
  scenes = std::make_unique<SceneStore>(*database, *blobs);
  jobs = std::make_unique<JobStore>(*database);
  LB_ASSIGN_OR_RETURN(const int again, jobs->recover());
  if (again > 0) log_event(LogLevel::kInfo, "jobs.recovered", {{"count", std::to_string(again)}});
  board = std::make_unique<JobBoard>(*jobs, *blobs, config.admission.max_queued_jobs);
  runner = std::make_unique<JobRunner>(config.data / "work", *blobs, config.run);
  executor = std::make_unique<Executor>(kExecutorThreads);
  context = std::make_unique<ServiceContext>(
      ServiceContext{*blobs, *scenes, *board, *executor, metrics, idle, engine, config.admission});
  return {};
}

Status Service::Parts::serve() {
  static std::once_flag plugins;
  std::call_once(plugins, [] {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  });
  grpc::ServerBuilder builder;
  services.push_back(make_blob_service(*context));
  services.push_back(make_scene_service(*context));
  services.push_back(make_job_service(*context));
  services.push_back(make_capability_service(*context));
  for (const auto& service : services) builder.RegisterService(service.get());
  builder.SetMaxReceiveMessageSize(kMaxMessageBytes);
  builder.SetMaxSendMessageSize(kMaxMessageBytes);
  grpc::ResourceQuota quota("lightbatch");
  quota.Resize(kCallMemory);
  builder.SetResourceQuota(quota);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kStreamsPerConnection);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 30'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 10'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  if (!config.listen.empty()) {
    LB_ASSIGN_OR_RETURN(const auto secrets, credentials(config));
    builder.AddListeningPort(config.listen, secrets, &port);
  }
  server = builder.BuildAndStart();
  if (server == nullptr || (!config.listen.empty() && port == 0)) {
    return Status(StatusCode::kUnavailable, "ADDRESS_TAKEN",
                  "cannot listen on " + config.listen + "; is another daemon running there?");
  }
  if (config.admin_port >= 0) {
    LB_ASSIGN_OR_RETURN(
        admin, AdminHttp::start(config.admin_address, static_cast<std::uint16_t>(config.admin_port),
                                [this](std::string_view path) {
                                  return admin_page(*context, *database, path);
                                }));
  }
  for (int i = 0; i < std::max(1, config.admission.concurrent_jobs); ++i) {
    job_threads.emplace_back([this] { run_jobs(); });
  }
  sweeper = std::thread([this] { sweep(); });
  // Health last: ready means ready.
  if (auto* health = server->GetHealthCheckService()) {
    for (const char* name : kServiceNames) health->SetServingStatus(name, true);
  }
  return {};
}

void Service::Parts::run_jobs() {
  while (const auto claim = board->claim()) run_job(*claim);
}

void Service::Parts::run_job(const JobBoard::Claim& claim) {
  const std::string& name = claim.job.name();
  log_event(LogLevel::kInfo, "job.started",
            {{"job", name},
             {"scene", claim.job.scene()},
             {"kind", v1::JobKind_Name(claim.job.options().kind())},
             {"attempt", std::to_string(claim.job.attempt())}});
  const auto start = std::chrono::steady_clock::now();
  const auto scene = scenes->get(claim.job.scene());
  RunResult result;
  if (scene.ok()) {
    result = runner->run(
        claim.job, *scene, *claim.cancel,
        [&](std::string_view phase, double fraction) { board->progress(name, phase, fraction); });
  } else {
    result.status = scene.status();
  }
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  metrics.add_job_seconds(seconds);
  if (result.status.reason() == "WORKER_CRASHED") ++metrics.worker_crashes;
  const Status status = result.status;
  const std::int64_t peak = result.peak_memory_bytes;
  if (board->end(name, std::move(result)) == v1::JOB_STATE_QUEUED) {
    log_event(LogLevel::kInfo, "job.requeued", {{"job", name}});
    return;
  }
  log_event(status.ok() ? LogLevel::kInfo : LogLevel::kWarning, "job.ended",
            {{"job", name},
             {"outcome", status.ok() ? "OK" : status.reason()},
             {"message", status.message()},
             {"seconds", std::to_string(seconds)},
             {"peak_memory_bytes", std::to_string(peak)}});
}

void Service::Parts::sweep() {
  std::unique_lock guard(stop_mutex);
  const bool limited = config.retention.keep_seconds > 0 || config.retention.max_bytes > 0;
  auto collect_at = std::chrono::steady_clock::now();
  while (!stop_changed.wait_for(guard, std::chrono::seconds(5), [this] { return stopped; })) {
    idle.sweep(std::chrono::duration<double>(config.idle_seconds));
    if (!limited || std::chrono::steady_clock::now() < collect_at) continue;
    collect_at = std::chrono::steady_clock::now() + kCollectInterval;
    guard.unlock();
    collect_old();
    guard.lock();
  }
}

void Service::Parts::collect_old() {
  const auto collected = collect(*database, *blobs, config.retention);
  if (!collected.ok()) {
    log_event(LogLevel::kWarning, "store.not_collected",
              {{"reason", collected.status().reason()}, {"message", collected.status().message()}});
  } else if (collected->jobs + collected->scenes + collected->blobs > 0) {
    log_event(LogLevel::kInfo, "store.collected",
              {{"jobs", std::to_string(collected->jobs)},
               {"scenes", std::to_string(collected->scenes)},
               {"blobs", std::to_string(collected->blobs)},
               {"bytes", std::to_string(collected->bytes)}});
  }
}

Result<std::unique_ptr<Service>> Service::start(const ServiceConfig& config, const Engine& engine) {
  auto parts = std::make_unique<Parts>();
  parts->config = config;
  parts->engine = engine;
  std::unique_ptr<Service> service(new Service(std::move(parts)));
  LB_RETURN_IF_ERROR(service->parts_->open_stores());
  LB_RETURN_IF_ERROR(service->parts_->serve());
  return service;
}

Service::Service(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Service::~Service() { stop(); }

void Service::stop() {
  Parts& p = *parts_;
  {
    const std::lock_guard guard(p.stop_mutex);
    if (p.stopped) return;
    p.stopped = true;
  }
  p.stop_changed.notify_all();
  // Refuse, end streams, put jobs back, finish calls; metrics last.
  if (p.server) {
    if (auto* health = p.server->GetHealthCheckService()) health->SetServingStatus(false);
  }
  if (p.board) p.board->stop();
  for (std::thread& thread : p.job_threads) thread.join();
  if (p.sweeper.joinable()) p.sweeper.join();
  if (p.server) {
    p.server->Shutdown(std::chrono::system_clock::now() +
                       std::chrono::milliseconds(static_cast<int>(p.config.drain_seconds * 1000)));
    p.server->Wait();
    p.server.reset();
  }
  p.executor.reset();
  p.admin.reset();
}

int Service::port() const { return parts_->port; }
int Service::admin_port() const { return parts_->admin ? parts_->admin->port() : -1; }

std::shared_ptr<grpc::Channel> Service::in_process_channel() {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMaxMessageBytes);
  return parts_->server->InProcessChannel(arguments);
}

std::int64_t default_job_memory(int concurrent_jobs) {
  const std::int64_t bytes = static_cast<std::int64_t>(sysconf(_SC_PHYS_PAGES)) *
                             static_cast<std::int64_t>(sysconf(_SC_PAGE_SIZE));
  return bytes / 4 * 3 / std::max(1, concurrent_jobs);
}

}  // namespace lightbatch::server
