#pragma once

#include <vector>

#include "core/atlas/layout.h"
#include "core/lightmap/pages.h"

namespace lightbatch::lightmap {

/// Bilinear look-up as a sampler with clamp and linear does it; page coordinates in texels.
Rgb look_up(const PageImage& page, Vec2f at);

/// Irradiance that the lightmap shows at barycentric (u, v) of a triangle; black where the triangle
/// has no lightmap.
Rgb irradiance_at(const atlas::Layout& layout, const std::vector<PageImage>& pages,
                  std::uint32_t triangle, float u, float v);

}  // namespace lightbatch::lightmap
