#pragma once

#include <cstdint>

#include "core/atlas/layout.h"
#include "core/atlas/raster.h"

namespace lightbatch::atlas {

/// Counts, from the final coordinates alone, texels in the bilinear footprint of two charts.
std::uint64_t count_conflicts(const Layout& layout);

/// Fills charted_area, utilisation and out_of_density_area; wide: per chart, whether it counts
/// for the latter.
void measure(const scene::Scene& scene, const std::vector<bool>& wide, Layout& layout);

/// The triangle's coordinates on the grid. Exact for layouts made here; others are rounded.
GridTriangle grid_triangle(const Layout& layout, std::uint32_t triangle);

}  // namespace lightbatch::atlas
