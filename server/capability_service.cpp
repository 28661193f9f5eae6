#include <thread>

#include "lightbatch/v1/capability_service.grpc.pb.h"
#include "server/services.h"
#include "server/timestamps.h"
#include "server/unary_call.h"

namespace lightbatch::server {
namespace {

v1::Capabilities capabilities(const ServiceContext& context) {
  v1::Capabilities out;
  out.set_build_id(context.engine.build_id());
  for (const v1::JobKind kind :
       {v1::JOB_KIND_BAKE, v1::JOB_KIND_PLAN, v1::JOB_KIND_QUOTE, v1::JOB_KIND_SWEEP,
        v1::JOB_KIND_HIERARCHY, v1::JOB_KIND_RELIGHT, v1::JOB_KIND_VIEWS}) {
    out.add_job_kinds(kind);
  }
  out.set_max_message_bytes(kMaxMessageBytes);
  out.set_max_chunk_bytes(kMaxUploadChunk);
  out.set_max_blob_bytes(context.blobs.limits().max_blob_bytes);
  out.set_max_scene_files(kMaxSceneFiles);
  out.set_concurrent_jobs(context.limits.concurrent_jobs);
  out.set_max_queued_jobs(static_cast<std::int32_t>(context.limits.max_queued_jobs));
  out.set_max_uploads(context.limits.max_uploads);
  out.set_job_memory_bytes(context.limits.job_memory_bytes);
  *out.mutable_max_job_duration() = to_duration(context.limits.max_job_seconds);
  out.set_hardware_threads(static_cast<std::int32_t>(std::thread::hardware_concurrency()));
  return out;
}

class CapabilityService final : public v1::CapabilityService::CallbackService {
 public:
  explicit CapabilityService(ServiceContext& context) : context_(context) {}

  grpc::ServerUnaryReactor* GetCapabilities(grpc::CallbackServerContext* call,
                                            const v1::GetCapabilitiesRequest*,
                                            v1::Capabilities* response) override {
    return answer(context_, call, response,
                  [this]() -> Result<v1::Capabilities> { return capabilities(context_); });
  }

 private:
  ServiceContext& context_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_capability_service(ServiceContext& context) {
  return std::make_unique<CapabilityService>(context);
}

}  // namespace lightbatch::server
