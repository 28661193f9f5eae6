#pragma once

#include <nlohmann/json.hpp>

#include "core/accuracy/certificate.h"
#include "core/accuracy/leaks.h"
#include "core/accuracy/seams.h"
#include "core/pipeline/light_stage.h"

namespace lightbatch::pipeline {

/// Points anywhere in the shares of a texel's samples, new ones for every path, so that shadow
/// edges are judged by where they run and not by the baker's own pattern. Reads `places` when
/// asked.
accuracy::PointSource points_of(const LightmapPlaces& places, const atlas::Texel& texel);

/// Stage "certify": judges random texels, half by area and half by light, by path tracing.
Result<accuracy::Certificate> certify(const JobOptions& options, const Prepared& p,
                                      const LightmapPlaces& places, const LightBake& light,
                                      StageClock& clock, const Progress& progress);

/// What a viewer sees where charts end.
struct BorderChecks {
  accuracy::Seams seams;
  accuracy::Leaks leaks;
};
/// Stage "borders": seams and leaks of the finished pages.
Result<BorderChecks> check_borders(const JobOptions& options, const Prepared& p,
                                   const LightmapPlaces& places, const LightBake& light,
                                   const std::vector<lightmap::PageImage>& pages, StageClock& clock,
                                   const Progress& progress);

/// Paths of about a quarter of the price of a bake of so many rays.
std::uint64_t path_budget(const Prepared& p, double bake_rays);
/// Paths that a certificate may take: as many, but enough to tell the target from noise after a
/// small bake, too.
std::uint64_t certificate_budget(const Prepared& p, double bake_rays, double target);

/// What path tracing says of the texels of a pilot.
struct PilotTruth {
  double low = 0;             // lower end of the interval of relRMSE
  double seconds_a_path = 0;  // wall
};
/// Judges the selected texels with that many paths.
Result<PilotTruth> judge_pilot(const JobOptions& options, const Prepared& p,
                               const LightmapPlaces& places, const LightBake& light,
                               const std::vector<std::uint8_t>& selected, std::uint64_t paths,
                               const Progress& progress);

/// The accuracy section. passed: the estimate is not above the target.
nlohmann::json report_accuracy(const accuracy::Certificate& certificate, double target);
/// The borders section.
nlohmann::json report_borders(const scene::Scene& scene, const BorderChecks& checks);

}  // namespace lightbatch::pipeline
