#pragma once

#include <vector>

#include "core/lightmap/bake.h"
#include "core/lightmap/dim.h"

namespace lightbatch::lightmap {

/// Rays of every texel against the mean, in proportion to what it brings into the error of the map:
/// noise grows with the indirect light that the first stage found there (first, lux), and falls
/// with the rays to the power 0.7; its square counts by the texel's surface. The least sum of
/// squares for a number of rays has rays ~ (light^2 surface)^(1 / 2.4). Where dim places count by
/// their own light (dim), so many more.
std::vector<float> ray_shares(const BakeInput& input, const DimShares& dim,
                              const std::vector<Rgb>& first);

}  // namespace lightbatch::lightmap
