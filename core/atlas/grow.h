#pragma once

#include <cstdint>
#include <vector>

#include "core/atlas/facets.h"
#include "core/math/mat.h"

namespace lightbatch::atlas {

/// No normal of a chart deviates more from the normal it grew from: cos 54.7 degrees = 0.577, and
/// 0.71 / 0.577 < 1.3, so a projection can keep both singular values within +-30 %.
constexpr double kConeCosine = 0.58;
/// Folds sharper than 60 degrees are borders: light must not bleed over them.
constexpr double kFoldCosine = 0.5;

/// Facet -> chart, charts grown from the largest facets outwards, nearest normals first.
std::vector<std::uint32_t> grow_charts(const Mesh& mesh, const Facets& facets);

/// Facet -> chart: connected facets with the same dominant one of the frame's six half axes.
/// Better than growing on axis-aligned objects, whose grown charts wrap around corners.
std::vector<std::uint32_t> box_charts(const Mesh& mesh, const Facets& facets, const Affine& frame);

}  // namespace lightbatch::atlas
