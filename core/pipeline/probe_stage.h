#pragma once

#include <nlohmann/json.hpp>

#include "core/lightmap/bake.h"
#include "core/pipeline/prepare.h"
#include "core/probes/bake.h"

namespace lightbatch::pipeline {

/// Stage "probes": light probes where meshes move, as precise as the bake's target error asks.
Result<probes::LightProbes> bake_light_probes(const Prepared& p, const lightmap::BakeInput& input,
                                              const lightmap::GatherSettings& settings,
                                              StageClock& clock, const Progress& progress);

/// The probes section of report.json.
nlohmann::json report_probes(const probes::LightProbes& probes);

}  // namespace lightbatch::pipeline
