#pragma once

#include <limits>
#include <vector>

#include "core/pipeline/light_stage.h"
#include "core/pipeline/tune.h"

namespace lightbatch::pipeline {

/// One line of the price list.
struct Price {
  double target = 0;  // relRMSE asked for
  double error = 0;   // expected relRMSE of the texels
  double seconds =
      0;            // expected wall time of a whole bake that asks for it, its own pilot included
  double rest = 0;  // of these, what comes after the pilot
};

/// Errors that are always quoted.
constexpr double kQuotedErrors[] = {0.10, 0.05, 0.02, 0.01, 0.005};

/// Coarser ones that a tight time budget may buy.
constexpr double kCoarserErrors[] = {4.00, 0.80, 0.40, 0.20};

/// The price list of a scene and the pilots behind it, coarse ones first.
struct Quote {
  std::vector<Price> prices;   // of kQuotedErrors
  std::vector<Price> coarser;  // of kCoarserErrors
  std::vector<Tuned> pilots;
};

/// Pilots that bake a small share of the scene's texels, and what they tell; what the stages before
/// have taken is added. No further pilot is started once the clock stands above `patience` seconds.
/// Stage "pilot".
Result<Quote> quote(const JobOptions& options, const Prepared& p, const LightmapPlaces& places,
                    StageClock& clock, const Progress& progress,
                    double patience = std::numeric_limits<double>::infinity());

/// The smallest error whose `rest` is within `seconds`, between the lines of the price lists by
/// log-log interpolation; the largest when none fits.
double error_for_time(const Quote& quote, double seconds);

/// Settings for a target from the pilots of a quote, without a new one.
Tuned tuned_from(const Quote& quote, double target);

}  // namespace lightbatch::pipeline
