#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/batches/measure.h"
#include "core/batches/plan.h"
#include "core/hierarchy/statistics.h"
#include "core/pipeline/job.h"
#include "core/pipeline/light_stage.h"
#include "core/pipeline/prepare.h"
#include "core/pipeline/quote.h"
#include "core/pipeline/stage_clock.h"
#include "core/pipeline/tune.h"

namespace lightbatch::pipeline {

using Json = nlohmann::json;

// The sections of report.json; the schema is told in core/report/README.md.

/// schema, kind, input, options, build, scene, plan, hierarchy, warnings.
Json report_head(const JobOptions& options, const JobInput& input, const Prepared& p);
Json report_hierarchy(const hierarchy::Statistics& statistics, double build_seconds);
Json report_radiosity(const LightBake& bake);
/// Section "lightmaps" before anything is baked: charts, texels, density.
Json report_layout(const LightmapPlaces& places);
Json report_lightmaps(const LightmapPlaces& places, const lightmap::BakeCounts& counts,
                      const std::vector<lightmap::EncodedPage>& pages);
Json report_batches(const gltf::Document& document, const scene::Scene& scene,
                    const batches::BatchPlan& plan, const batches::ViewsReport& views,
                    const std::string& profile);
/// Section "expected": what the pilot foretells of the chosen settings.
Json report_expected(const Tuned& tuned);
Json report_quote(const std::vector<Price>& prices);
/// Counters of what was cast and looked up, and shares of the cost, into the plan's effects.
void report_counters(Json& report, const Prepared& p, const LightBake& bake);
/// stages and total.
void report_stages(Json& report, const StageClock& clock);

}  // namespace lightbatch::pipeline
