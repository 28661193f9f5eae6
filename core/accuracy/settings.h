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

/// Settings that meet `target_error` (relRMSE, clamped to [0.001, 0.3]) on ordinary interiors:
/// the ladder measured on closed-form and real scenes, interpolated on a log scale between rungs.
/// effort multiplies ray counts and divides areas of elements: 1 is the ladder itself.
BakeSettings settings_for(double target_error, const SceneMeasure& scene, std::uint64_t seed,
                          double effort = 1.0);

}  // namespace lightbatch::accuracy
