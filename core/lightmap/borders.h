#pragma once

#include <cstdint>
#include <vector>

#include "core/atlas/layout.h"
#include "core/atlas/texels.h"
#include "core/rays/caster.h"
#include "core/scene/scene.h"

namespace lightbatch::lightmap {

/// One point of a border where two charts meet on one surface, as either of them shows it.
struct BorderPoint {
  atlas::SurfacePoint here, there;
  double metres = 0;  // of border that it stands for
  bool flat = false;  // the surface does not fold there: the light does not change either
};

struct Borders {
  std::vector<BorderPoint> points;
  /// Left out: something stands between the two sides, or hangs within a texel above.
  double divided_metres = 0;
};

/// Follows the borders of all charts on surfaces that fold by at most 10 degrees, a point a texel.
/// phases, in (0, 1): where in each texel's stretch there is a point. Neighbours are found by
/// geometry alone: shared edges of welded positions, whatever node they belong to, and where an
/// edge is open by a ray down beside it. The same points on any number of threads.
Borders find_borders(const scene::Scene& scene, const rays::Caster& caster,
                     const atlas::Layout& layout, const atlas::TexelMap& texels,
                     const std::vector<double>& phases);

}  // namespace lightbatch::lightmap
