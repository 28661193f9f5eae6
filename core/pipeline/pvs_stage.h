#pragma once

#include <nlohmann/json.hpp>

#include "core/batches/visible_sets.h"
#include "core/pipeline/artifacts.h"
#include "core/pipeline/prepare.h"

namespace lightbatch::pipeline {

/// Stage "pvs": writes pvs.json (format: README of batches) and returns its section of report.json.
Result<nlohmann::json> write_visible_sets(const JobOptions& options, const Prepared& p,
                                          const batches::Viewpoints& viewpoints,
                                          const batches::BatchPlan& plan, Artifacts& artifacts,
                                          StageClock& clock, const Progress& progress);

}  // namespace lightbatch::pipeline
