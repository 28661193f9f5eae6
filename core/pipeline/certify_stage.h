#pragma once

#include <nlohmann/json.hpp>

#include "core/accuracy/certificate.h"
#include "core/pipeline/light_stage.h"

namespace lightbatch::pipeline {

/// Stage "certify": judges area-uniform random texels by path tracing.
Result<accuracy::Certificate> certify(const JobOptions& options, const Prepared& p,
                                      const LightmapPlaces& places, const LightBake& light,
                                      StageClock& clock, const Progress& progress);

/// Expected seconds of the certificate at a target, from a small run of it.
Result<double> certify_price(const JobOptions& options, const Prepared& p,
                             const LightmapPlaces& places, const LightBake& light, double target,
                             const Progress& progress);

/// The accuracy section. passed: the estimate is not above the target.
nlohmann::json report_accuracy(const accuracy::Certificate& certificate, double target);

}  // namespace lightbatch::pipeline
