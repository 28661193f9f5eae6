#include "core/pipeline/job.h"

#include <cmath>
#include <exception>
#include <new>

#include "core/base/parallel.h"
#include "core/optics/environment.h"
#include "core/pipeline/jobs.h"

namespace lightbatch::pipeline {

std::string build_id() { return "lightbatch 0.1.0"; }

Status validate(const JobOptions& o) {
  const auto finite = [](double v) { return std::isfinite(v); };
  if (!finite(o.target_error) || o.target_error < 0 || o.target_error > 1) {
    return bad_option("target error: a share between 0 and 1, for instance 2% or 0.02");
  }
  if (o.target_error > 0 && o.target_error < 0.001) {
    return bad_option("target error: at least 0.1%");
  }
  if (!finite(o.time_budget) || o.time_budget < 0) {
    return bad_option("time budget: a positive number of seconds");
  }
  if (o.target_error > 0 && o.time_budget > 0) {
    return bad_option("name a target error or a time budget, not both");
  }
  if (o.texels_per_metre != 0 && !(o.texels_per_metre >= 1e-6 && o.texels_per_metre <= 1e6)) {
    return bad_option("texels per metre: 1e-6 to 1e6");
  }
  if (o.lightmap_size < 64 || o.lightmap_size > 8192) {
    return bad_option("lightmap size: 64 to 8192 texels");
  }
  if (!(o.sky_nits >= 0 && o.sky_nits <= optics::kMostRadiance)) {
    return bad_option("sky: a luminance in nits, from 0 to 1e30");
  }
  if (o.sky_nits > 0 && !o.sky_file.empty()) {
    return bad_option("sky: a luminance or a file, not both");
  }
  if (o.max_batches < 0) return bad_option("max batches: at least 0");
  if (o.max_vertices != 0 && o.max_vertices < 3) return bad_option("max vertices: at least 3");
  if (!(o.max_growth >= 1 && o.max_growth <= 1e6)) return bad_option("max growth: 1 to 1e6");
  if (!(o.draws_share > 0 && o.draws_share <= 1)) {
    return bad_option("share of draws: above 0 and at most 1");
  }
  if (o.threads < 0 || o.threads > 1024) return bad_option("threads: 0 (all) to 1024");
  if (o.kind == JobKind::kBake && !o.batches && !o.lightmaps &&
      o.compression == Compression::kAsInput) {
    return bad_option("without batches and without lightmaps nothing is left to do");
  }
  if (o.quantization == Quantization::kAll && o.compression == Compression::kDraco) {
    return bad_option("Draco rounds by itself: quantize or compress with draco, not both");
  }
  if (o.pvs && !o.batches) return bad_option("potentially visible sets are of batches: allow them");
  if (!o.lightmaps && o.carrier != Carrier::kLightmap) {
    return bad_option("the carrier names how lightmaps travel; it contradicts no lightmaps");
  }
  if (o.kind == JobKind::kSweep) {
    for (const double e : o.sweep_errors) {
      if (!finite(e) || e < 0.001 || e > 1) return bad_option("sweep errors: 0.1% to 100%");
    }
  }
  if (o.kind == JobKind::kRelight && o.lights_file.empty()) {
    return bad_option("a relight needs a file of new lights");
  }
  for (const int level : o.levels) {
    if (level < 0 || level > 1000) return bad_option("levels: 0 to 1000");
  }
  return {};
}

Result<JobOutcome> run_job(const JobOptions& options, const JobInput& input,
                           const std::filesystem::path& output, const Progress& progress) {
  LB_RETURN_IF_ERROR(validate(options));
  if (options.threads > 0) set_thread_count(options.threads);
  try {
    switch (options.kind) {
      case JobKind::kBake:
        return run_bake(options, input, output, progress);
      case JobKind::kPlan:
        return run_plan(options, input, output, progress);
      case JobKind::kQuote:
        return run_quote(options, input, output, progress);
      case JobKind::kSweep:
        return run_sweep(options, input, output, progress);
      case JobKind::kHierarchy:
        return run_hierarchy(options, input, output, progress);
      case JobKind::kViews:
        return run_views(options, input, output, progress);
      case JobKind::kRelight:
        return run_relight(options, input, output, progress);
    }
  } catch (const std::bad_alloc&) {
    return over_budget(input.scene, "the job needs more memory than it may use");
  } catch (const std::exception& e) {
    return Status(StatusCode::kInternal, "INTERNAL",
                  std::string("unexpected failure: ") + e.what());
  }
  return Status(StatusCode::kInternal, "INTERNAL", "unknown kind of job");
}

}  // namespace lightbatch::pipeline
