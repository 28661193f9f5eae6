#pragma once

#include <cstdint>
#include <vector>

#include "core/atlas/grid.h"
#include "core/atlas/mask.h"
#include "core/atlas/split.h"

namespace lightbatch::atlas {

/// A chart in texels: its corner on the centre of texel (0, 0).
struct BlockChart {
  Mask mask;  // texels of the bilinear footprint
  Vec3f axis;
  std::uint32_t first_triangle = 0;  // of the mesh
  std::uint32_t triangle_count = 0;
  bool tiny = false;  // a texel shared by charts of one cell and direction
  bool wide = false;  // at least two texels both ways
};

/// All charts of one mesh at one density, not yet placed.
struct Block {
  std::vector<BlockChart> charts;
  std::vector<std::uint32_t> chart_of;  // per mesh triangle
  std::vector<GridTriangle> uv;         // per mesh triangle, from its chart's first texel centre
};

/// Sizes are rounded to whole texels where both singular values stay within +-30 % of the density,
/// so that borders fall on texel centres and need no further gutter; sides below half a texel
/// collapse to a line of centres. Charts that collapse both ways share one texel per cell of one
/// texel's size and dominant direction.
Block raster_charts(const Mesh& mesh, const ChartSet& set, double density, int max_side);

}  // namespace lightbatch::atlas
