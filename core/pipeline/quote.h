#pragma once

#include <vector>

#include "core/pipeline/light_stage.h"

namespace lightbatch::pipeline {

/// One line of the price list.
struct Price {
  double target = 0;   // relRMSE asked for
  double error = 0;    // expected relRMSE of the texels
  double seconds = 0;  // expected wall time of the whole bake, its own pilot included
};

/// Errors that are always quoted.
constexpr double kQuotedErrors[] = {0.10, 0.05, 0.02, 0.01, 0.005};

/// The price list of a scene, from pilots that bake a small share of its texels; what the stages
/// before have taken is added. Stage "pilot".
Result<std::vector<Price>> quote(const JobOptions& options, const Prepared& p,
                                 const LightmapPlaces& places, StageClock& clock,
                                 const Progress& progress);

/// The smallest error whose expected time is within `seconds`, between the lines of a price list by
/// log-log interpolation; the largest quoted error when none fits.
double error_for_time(const std::vector<Price>& prices, double seconds);

}  // namespace lightbatch::pipeline
