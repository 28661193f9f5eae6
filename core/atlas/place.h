#pragma once

#include <cstdint>
#include <vector>

#include "core/atlas/density.h"
#include "core/atlas/grid.h"
#include "core/atlas/pack.h"
#include "core/atlas/raster.h"

namespace lightbatch::atlas {

/// The charts of one shape at one size, placed once for each instance.
struct PlacedUse {
  std::uint32_t shape = 0, use = 0;  // into the charted shapes and their uses
  Block block;
  /// The charts packed together as one block, when several instances share them; else empty and
  /// every chart of every instance is placed alone.
  std::vector<Placement> inside;
  Mask outline;                       // of that block
  std::vector<Placement> placements;  // per instance: one for the block, or one for each chart
};

struct Placed {
  std::vector<PlacedUse> uses;
  std::vector<Page> pages;
  double texels = 0;
};

/// Charts at a density (texels per metre) to pages. No uses when cancelled.
Placed place_charts(const std::vector<ChartedShape>& shapes, double density, int page_size,
                    const Progress& progress);

/// A point of a chart or block, counted from its first texel centre, after placement.
GridPoint placed_point(const GridPoint& p, const Placement& at, int width, int height);

}  // namespace lightbatch::atlas
