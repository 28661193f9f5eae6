#pragma once

#include <cstdint>
#include <vector>

#include "core/atlas/layout.h"
#include "core/atlas/texels.h"
#include "core/lightmap/pages.h"
#include "core/rays/caster.h"
#include "core/scene/scene.h"

namespace lightbatch::accuracy {

/// Steps of what a viewer shows where two charts meet, as shares of the mean irradiance: the root
/// of the mean square over the channels at a point, pooled over points by the length they stand
/// for.
struct StepFigures {
  double metres = 0;
  std::uint64_t points = 0;
  double rms = 0;
  double p95 = 0;
  double largest = 0;
};

struct Seams {
  StepFigures flat;           // the surface does not fold there: the light does not change either
  StepFigures folded;         // by 1 to 10 degrees: the change of the light itself is in the step
  double divided_metres = 0;  // left out: something stands between the two sides,
                              // or hangs within a texel above
};

/// Follows the borders of all charts (lightmap::find_borders), a point a texel, and reads the
/// finished pages on both sides by bilinear look-up through the final coordinates.
/// mean_irradiance: lux. The same figures on any number of threads.
Seams measure_seams(const scene::Scene& scene, const rays::Caster& caster,
                    const atlas::Layout& layout, const atlas::TexelMap& texels,
                    const std::vector<lightmap::PageImage>& pages, double mean_irradiance);

}  // namespace lightbatch::accuracy
