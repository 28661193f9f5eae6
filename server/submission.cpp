#include "server/submission.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include <algorithm>
#include <cmath>

#include "core/base/bytes.h"
#include "core/base/hash.h"
#include "server/executable.h"
#include "server/names.h"
#include "server/rpc_status.h"
#include "server/timestamps.h"

namespace lightbatch::server {
namespace {

constexpr std::size_t kMaxRequestIdBytes = 64;
constexpr std::size_t kMaxDisplayNameBytes = 256;

/// Maps and unknown fields in one fixed order.
std::string deterministic_bytes(const google::protobuf::Message& message) {
  std::string bytes;
  google::protobuf::io::StringOutputStream stream(&bytes);
  google::protobuf::io::CodedOutputStream coded(&stream);
  coded.SetSerializationDeterministic(true);
  message.SerializeToCodedStream(&coded);
  coded.Trim();
  return bytes;
}

Status unknown_enum(const char* field) {
  return bad_option(std::string("this server does not know this value of ") + field);
}

bool has_file(const v1::Scene& scene, const std::string& path) {
  return std::any_of(scene.files().begin(), scene.files().end(),
                     [&](const v1::SceneFile& file) { return file.path() == path; });
}

/// A file that an option names must be in the manifest.
Status check_named_file(const v1::Scene& scene, const std::string& path, const char* field) {
  if (path.empty() || has_file(scene, path)) return {};
  return bad_option(std::string(field) + " names \"" + path.substr(0, 200) +
                    "\", which is not a file of the scene's manifest; add it there");
}

}  // namespace

Result<pipeline::JobOptions> to_pipeline(const v1::JobOptions& in) {
  pipeline::JobOptions out;
  switch (in.kind()) {
    case v1::JOB_KIND_UNSPECIFIED:
    case v1::JOB_KIND_BAKE:
      out.kind = pipeline::JobKind::kBake;
      break;
    case v1::JOB_KIND_PLAN:
      out.kind = pipeline::JobKind::kPlan;
      break;
    case v1::JOB_KIND_QUOTE:
      out.kind = pipeline::JobKind::kQuote;
      break;
    case v1::JOB_KIND_SWEEP:
      out.kind = pipeline::JobKind::kSweep;
      break;
    case v1::JOB_KIND_HIERARCHY:
      out.kind = pipeline::JobKind::kHierarchy;
      break;
    case v1::JOB_KIND_RELIGHT:
      out.kind = pipeline::JobKind::kRelight;
      break;
    case v1::JOB_KIND_VIEWS:
      out.kind = pipeline::JobKind::kViews;
      break;
    default:
      return unknown_enum("kind");
  }
  switch (in.carrier()) {
    case v1::CARRIER_UNSPECIFIED:
    case v1::CARRIER_LIGHTMAP:
      out.carrier = pipeline::Carrier::kLightmap;
      break;
    case v1::CARRIER_PORTABLE:
      out.carrier = pipeline::Carrier::kPortable;
      break;
    case v1::CARRIER_BOTH:
      out.carrier = pipeline::Carrier::kBoth;
      break;
    default:
      return unknown_enum("carrier");
  }
  switch (in.lights()) {
    case v1::LIGHTS_POLICY_UNSPECIFIED:
    case v1::LIGHTS_POLICY_REMOVE:
      out.lights = pipeline::LightsPolicy::kRemove;
      break;
    case v1::LIGHTS_POLICY_KEEP:
      out.lights = pipeline::LightsPolicy::kKeep;
      break;
    default:
      return unknown_enum("lights");
  }
  switch (in.solver()) {
    case v1::SOLVER_MODE_UNSPECIFIED:
      out.solver = pipeline::SolverMode::kAuto;
      break;
    case v1::SOLVER_MODE_STORED_RAY:
      out.solver = pipeline::SolverMode::kStoredRay;
      break;
    case v1::SOLVER_MODE_LINKED:
      out.solver = pipeline::SolverMode::kLinked;
      break;
    default:
      return unknown_enum("solver");
  }
  switch (in.compression()) {
    case v1::COMPRESSION_UNSPECIFIED:
      out.compression = pipeline::Compression::kAsInput;
      break;
    case v1::COMPRESSION_NONE:
      out.compression = pipeline::Compression::kNone;
      break;
    case v1::COMPRESSION_MESHOPT:
      out.compression = pipeline::Compression::kMeshopt;
      break;
    case v1::COMPRESSION_DRACO:
      out.compression = pipeline::Compression::kDraco;
      break;
    default:
      return unknown_enum("compression");
  }
  switch (in.quantization()) {
    case v1::QUANTIZATION_UNSPECIFIED:
      out.quantization = pipeline::Quantization::kAsInput;
      break;
    case v1::QUANTIZATION_NONE:
      out.quantization = pipeline::Quantization::kNone;
      break;
    case v1::QUANTIZATION_ALL:
      out.quantization = pipeline::Quantization::kAll;
      break;
    default:
      return unknown_enum("quantization");
  }
  out.max_vertices = in.max_vertices();
  if (in.max_growth() != 0) out.max_growth = in.max_growth();
  if (in.draws_share() != 0) out.draws_share = in.draws_share();
  out.keep_materials = in.keep_materials();
  out.other_scenes.assign(in.other_scenes().begin(), in.other_scenes().end());
  out.target_error = in.target_error();
  out.time_budget = in.time_budget_seconds();
  out.texels_per_metre = in.texels_per_metre();
  if (in.lightmap_size() != 0) out.lightmap_size = in.lightmap_size();
  out.sky_nits = in.sky_nits();
  out.sky_file = in.sky_file();
  if (!in.profile().empty()) out.profile = in.profile();
  out.max_batches = in.max_batches();
  out.batches = !in.skip_batches();
  out.lightmaps = !in.skip_lightmaps();
  out.effects.assign(in.effects().begin(), in.effects().end());
  if (in.has_seed()) out.seed = in.seed();
  out.threads = in.threads();
  out.sweep_errors.assign(in.sweep_errors().begin(), in.sweep_errors().end());
  out.levels.assign(in.levels().begin(), in.levels().end());
  out.compare = in.compare();
  out.lights_file = in.lights_file();
  out.cameras_file = in.cameras_file();
  out.pvs = in.pvs();
  return out;
}

std::string canonical_bytes(const v1::JobOptions& options) {
  const pipeline::JobOptions defaults;
  v1::JobOptions full = options;
  full.DiscardUnknownFields();
  if (full.kind() == 0) full.set_kind(v1::JOB_KIND_BAKE);
  if (full.carrier() == 0) full.set_carrier(v1::CARRIER_LIGHTMAP);
  if (full.lights() == 0) full.set_lights(v1::LIGHTS_POLICY_REMOVE);
  if (full.lightmap_size() == 0) full.set_lightmap_size(defaults.lightmap_size);
  if (full.max_growth() == 0) full.set_max_growth(defaults.max_growth);
  if (full.draws_share() == 0) full.set_draws_share(defaults.draws_share);
  if (full.profile().empty()) full.set_profile(defaults.profile);
  if (!full.has_seed()) full.set_seed(defaults.seed);
  full.set_threads(0);
  return deterministic_bytes(full);
}

std::string cache_key(const std::string& manifest_sha256, const v1::JobOptions& options,
                      const std::string& build_id) {
  return sha256_hex(as_bytes(manifest_sha256 + '\n' + build_id + '\n' + canonical_bytes(options)));
}

std::string request_sha256(const v1::SubmitJobRequest& request) {
  v1::SubmitJobRequest content = request;
  content.clear_request_id();
  return sha256_hex(as_bytes(deterministic_bytes(content)));
}

Result<JobStore::Submission> make_submission(const v1::SubmitJobRequest& request,
                                             const v1::Scene& scene, const Engine& engine,
                                             double max_job_seconds) {
  if (request.request_id().size() > kMaxRequestIdBytes) {
    return bad_request("request_id has at most 64 bytes", "request_id");
  }
  if (request.display_name().size() > kMaxDisplayNameBytes) {
    return bad_request("display_name has at most 256 bytes", "display_name");
  }
  const double timeout = to_seconds(request.timeout());
  if (request.has_timeout() && !(timeout > 0 && timeout <= max_job_seconds)) {
    return bad_request("timeout must be above 0 and at most the server's " +
                           std::to_string(std::llround(max_job_seconds)) + " s",
                       "timeout");
  }
  LB_ASSIGN_OR_RETURN(const pipeline::JobOptions options, to_pipeline(request.options()));
  LB_RETURN_IF_ERROR(engine.validate(options));
  LB_RETURN_IF_ERROR(check_named_file(scene, options.sky_file, "sky_file"));
  LB_RETURN_IF_ERROR(check_named_file(scene, options.lights_file, "lights_file"));
  LB_RETURN_IF_ERROR(check_named_file(scene, options.cameras_file, "cameras_file"));
  for (const std::string& other : options.other_scenes)
    LB_RETURN_IF_ERROR(check_named_file(scene, other, "other_scenes"));
  if (options.profile.ends_with(".json")) {
    LB_RETURN_IF_ERROR(check_named_file(scene, options.profile, "profile"));
  }
  JobStore::Submission submission;
  v1::Job& job = submission.job;
  job.set_name("jobs/" + random_id());
  job.set_scene(request.scene());
  *job.mutable_options() = request.options();
  job.set_state(v1::JOB_STATE_QUEUED);
  job.set_sequence(1);
  *job.mutable_create_time() = to_timestamp(now_us());
  job.set_display_name(request.display_name());
  if (request.has_timeout()) *job.mutable_timeout() = request.timeout();
  submission.request_id = request.request_id();
  submission.request_sha256 = request_sha256(request);
  submission.cache_key = cache_key(scene.manifest_sha256(), request.options(),
                                   engine.build_id() + '\n' + executable_digest());
  return submission;
}

}  // namespace lightbatch::server
