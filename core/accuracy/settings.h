#pragma once

#include <cstdint>

#include "core/lightmap/bake.h"
#include "core/radiosity/elements.h"
#include "core/radiosity/solver.h"

namespace lightbatch::accuracy {

/// Everything that trades time for error, in one place.
struct BakeSettings {
  double target_error = 0.02;  // what the settings were chosen for
  radiosity::ElementOptions elements;
  radiosity::SolverOptions solver;
  lightmap::GatherSettings gather;
};

/// What the choice needs to know of a scene.
struct SceneMeasure {
  double reflecting_area = 0;  // m2, both sides of two-sided surfaces
  std::uint64_t texels = 0;
};

/// Where the ladder of settings is read for each part of the light. The ladder's own figures hold
/// for an ordinary room; a pilot (see tuning.h) finds where a scene of its own kind has to read it.
struct Rungs {
  double target = 0.02;  // relRMSE that is asked for
  double direct = 0.02;  // nominal error of direct light's settings
  double first = 0.02;   // of the first stage's
  double gather = 0.02;  // of the gather's
};

/// Ends of the ladder.
constexpr double kCoarsestRung = 0.3;
constexpr double kFinestRung = 0.0005;

/// Of dim places' share of the allowed error (lightmap/dim.h): 0 down to a target of 2 %, where
/// error counts against the mean light alone, 0.6 from 1 % on.
double dim_exponent(double target);

/// The ladder interpolated on a log scale between rungs; errors are clamped to its ends.
BakeSettings settings_for(const Rungs& rungs, const SceneMeasure& scene, std::uint64_t seed);

/// The ladder's own figures for a target.
inline BakeSettings settings_for(double target, const SceneMeasure& scene, std::uint64_t seed) {
  return settings_for(Rungs{target, target, target, target}, scene, seed);
}

}  // namespace lightbatch::accuracy
