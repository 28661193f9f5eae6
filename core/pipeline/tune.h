#pragma once

#include <limits>

#include "core/pipeline/pilot.h"

namespace lightbatch::pipeline {

/// Pilot and choice for one target.
struct Tuned {
  accuracy::Rungs rungs;
  Pilot pilot;
  /// The pilot's first stage where it is good enough for the rungs.
  std::shared_ptr<const FirstStage> first;
  double seconds = 0;  // wall, of all its pilots
};

/// Light of a fixed small share of the texels is baked twice, from other first stages and other
/// rays, at coarse rungs; where the choice falls far from these, once or twice more. The runs'
/// difference tells the error of both, path tracing what is wrong in both. Apart from the seconds,
/// the same on every run, unless `patience` is given: no further time once these seconds are gone.
/// CANCELLED.
Result<Tuned> tune(const JobOptions& options, const Prepared& p, const LightmapPlaces& places,
                   double target, const Progress& progress,
                   double patience = std::numeric_limits<double>::infinity());

}  // namespace lightbatch::pipeline
