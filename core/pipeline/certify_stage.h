#pragma once

#include <nlohmann/json.hpp>

#include "core/accuracy/certificate.h"
#include "core/pipeline/light_stage.h"

namespace lightbatch::pipeline {

/// Points anywhere in the shares of a texel's samples, new ones for every path, so that shadow
/// edges are judged by where they run and not by the baker's own pattern. Reads `places` when
/// asked.
accuracy::PointSource points_of(const LightmapPlaces& places, const atlas::Texel& texel);

/// Stage "certify": judges area-uniform random texels by path tracing.
Result<accuracy::Certificate> certify(const JobOptions& options, const Prepared& p,
                                      const LightmapPlaces& places, const LightBake& light,
                                      StageClock& clock, const Progress& progress);

/// Paths that a certificate may take after a bake of so many rays: about a quarter of its price.
std::uint64_t path_budget(const Prepared& p, double bake_rays);

/// Wall seconds of one path of a certificate, from a small run of it.
Result<double> seconds_a_path(const JobOptions& options, const Prepared& p,
                              const LightmapPlaces& places, const LightBake& light,
                              const Progress& progress);

/// The accuracy section. passed: the estimate is not above the target.
nlohmann::json report_accuracy(const accuracy::Certificate& certificate, double target);

}  // namespace lightbatch::pipeline
