#include "lightbatch/client.h"

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

#include <random>

#include "client/src/channel.h"

namespace lightbatch::client {
namespace {

grpc::ChannelArguments channel_arguments() {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 30'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 1'000);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  return arguments;
}

std::string make_request_id() {
  std::random_device random;
  std::string id;
  for (int i = 0; i < 4; ++i) {
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", static_cast<unsigned>(random()));
    id += digits;
  }
  return id;
}

bool has_ended(const v1::Job& job) {
  return job.state() == v1::JOB_STATE_SUCCEEDED || job.state() == v1::JOB_STATE_FAILED ||
         job.state() == v1::JOB_STATE_CANCELLED;
}

}  // namespace

std::string Error::to_string() const {
  std::string text = message;
  if (!place.empty()) text += " (at " + place + ")";
  if (!reason.empty()) text += " [" + reason + "]";
  return text;
}

Error to_error(const grpc::Status& status) {
  Error error;
  error.code = static_cast<int>(status.error_code());
  error.message = status.error_message();
  v1::RpcStatus rich;
  v1::ErrorDetail detail;
  if (rich.ParseFromString(status.error_details()) && rich.details_size() > 0 &&
      rich.details(0).UnpackTo(&detail)) {
    error.reason = detail.reason();
    error.place = detail.place();
    error.metadata.insert(detail.metadata().begin(), detail.metadata().end());
  } else {
    error.unreachable = may_retry(status);
  }
  return error;
}

Client::Client(std::unique_ptr<Calls> calls) : calls_(std::move(calls)) {}
Client::~Client() = default;

std::unique_ptr<Client> Client::over(std::shared_ptr<grpc::Channel> channel) {
  auto calls = std::make_unique<Calls>();
  calls->blobs = v1::BlobService::NewStub(channel);
  calls->scenes = v1::SceneService::NewStub(channel);
  calls->jobs = v1::JobService::NewStub(channel);
  calls->capabilities = v1::CapabilityService::NewStub(channel);
  calls->channel = std::move(channel);
  return std::unique_ptr<Client>(new Client(std::move(calls)));
}

std::unique_ptr<Client> Client::connect(const std::string& address) {
  return over(
      grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), channel_arguments()));
}

std::unique_ptr<Client> Client::connect(const std::string& address, const TlsOptions& tls) {
  const grpc::SslCredentialsOptions options = {tls.authority_pem, tls.key_pem, tls.certificate_pem};
  return over(
      grpc::CreateCustomChannel(address, grpc::SslCredentials(options), channel_arguments()));
}

void Client::set_patience(double seconds) { calls_->patience = seconds; }

Outcome<v1::Capabilities> Client::capabilities() {
  return unary<v1::Capabilities>(calls_->patience, [&](auto* context, auto* response) {
    return calls_->capabilities->GetCapabilities(context, {}, response);
  });
}

Outcome<v1::Job> Client::submit(v1::SubmitJobRequest request) {
  if (request.request_id().empty()) request.set_request_id(make_request_id());
  return unary<v1::Job>(calls_->patience, [&](auto* context, auto* response) {
    return calls_->jobs->SubmitJob(context, request, response);
  });
}

Outcome<v1::Job> Client::get(const std::string& name) {
  v1::GetJobRequest request;
  request.set_name(name);
  return unary<v1::Job>(calls_->patience, [&](auto* context, auto* response) {
    return calls_->jobs->GetJob(context, request, response);
  });
}

Outcome<v1::ListJobsResponse> Client::list(const v1::ListJobsRequest& request) {
  return unary<v1::ListJobsResponse>(calls_->patience, [&](auto* context, auto* response) {
    return calls_->jobs->ListJobs(context, request, response);
  });
}

Outcome<v1::Job> Client::cancel(const std::string& name) {
  v1::CancelJobRequest request;
  request.set_name(name);
  return unary<v1::Job>(calls_->patience, [&](auto* context, auto* response) {
    return calls_->jobs->CancelJob(context, request, response);
  });
}

Outcome<v1::Job> Client::watch(const std::string& name,
                               const std::function<bool(const v1::Job&)>& on_change) {
  v1::Job last;
  v1::WatchJobRequest request;
  request.set_name(name);
  for (Retry retry(calls_->patience);;) {
    grpc::ClientContext context;
    const auto stream = calls_->jobs->WatchJob(&context, request);
    v1::JobEvent event;
    while (stream->Read(&event)) {
      request.set_after_sequence(event.sequence());
      last = std::move(*event.mutable_job());
      retry.restart(calls_->patience);
      if (!on_change(last)) {
        context.TryCancel();
        static_cast<void>(stream->Finish());
        return last;
      }
    }
    const grpc::Status status = stream->Finish();
    if (status.ok() && has_ended(last)) return last;
    if (status.ok()) return get(name);  // ended before the cursor
    if (!may_retry(status) || !retry.wait()) return to_error(status);
  }
}

}  // namespace lightbatch::client
