#pragma once

#include <cstdint>
#include <vector>

#include "core/atlas/project.h"
#include "core/math/mat.h"

namespace lightbatch::atlas {

/// All charts of one mesh.
struct ChartSet {
  std::vector<std::uint32_t> of;  // mesh triangle -> chart
  std::vector<FlatChart> charts;
};

/// Charts grown by normals or, where that takes fewer texels at this density, cut along the axes
/// of `frame`, decided for each connected part. The density steers the choice only.
ChartSet make_charts(const Mesh& mesh, const Affine& frame, double density, int max_side);

/// Texels per metre along a chart's sides: the density, or less where the side would not fit.
Vec2d chart_scale(const FlatChart& chart, double density, int max_side);

/// Cuts charts that are wider than max_side texels (where triangles allow it) and charts that
/// would lie on themselves: triangles that hit covered samples, 2 x 2 a texel, leave together.
void split_charts(const Mesh& mesh, double density, int max_side, ChartSet& set);

}  // namespace lightbatch::atlas
