#pragma once

#include <string>

#include "core/base/status.h"
#include "core/pipeline/job.h"
#include "lightbatch/v1/job_service.pb.h"
#include "lightbatch/v1/scene_service.pb.h"
#include "server/engine.h"
#include "server/job_store.h"

namespace lightbatch::server {

/// The interface's options as the pipeline's, defaults filled in. BAD_OPTION for an enum value
/// that this build does not know.
Result<pipeline::JobOptions> to_pipeline(const v1::JobOptions& options);

/// Options with every default written out and without the thread count, which results do not
/// depend on: equal bytes mean equal work.
std::string canonical_bytes(const v1::JobOptions& options);

/// SHA-256 of scene manifest, canonical options and build: names the result of a job.
std::string cache_key(const std::string& manifest_sha256, const v1::JobOptions& options,
                      const std::string& build_id);

/// SHA-256 of a request without its request_id.
std::string request_sha256(const v1::SubmitJobRequest& request);

/// Checks a request against the scene it names; the job is QUEUED and has its name.
/// BAD_OPTION, BAD_REQUEST.
Result<JobStore::Submission> make_submission(const v1::SubmitJobRequest& request,
                                             const v1::Scene& scene, const Engine& engine,
                                             double max_job_seconds);

}  // namespace lightbatch::server
