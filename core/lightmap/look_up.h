#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/atlas/layout.h"
#include "core/lightmap/pages.h"

namespace lightbatch::lightmap {

/// The pixels of a bilinear look-up at page coordinates in texels, clamped to the page.
struct Taps {
  std::array<std::size_t, 4> pixel{};
  std::array<float, 4> weight{};
};
Taps taps_at(const PageImage& page, Vec2f at);

/// Page coordinates, in texels, of barycentric (u, v) of a triangle with a lightmap.
Vec2f page_place(const atlas::Layout& layout, std::uint32_t triangle, float u, float v);

/// Bilinear look-up as a sampler with clamp and linear does it; page coordinates in texels.
Rgb look_up(const PageImage& page, Vec2f at);
Rgb look_up(const PageImage& page, const Taps& taps);

/// Irradiance that the lightmap shows at barycentric (u, v) of a triangle; black where the triangle
/// has no lightmap.
Rgb irradiance_at(const atlas::Layout& layout, const std::vector<PageImage>& pages,
                  std::uint32_t triangle, float u, float v);

}  // namespace lightbatch::lightmap
