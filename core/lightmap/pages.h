#pragma once

#include <vector>

#include "core/atlas/layout.h"
#include "core/atlas/texels.h"
#include "core/base/bytes.h"
#include "core/base/status.h"
#include "core/image/image.h"

namespace lightbatch::lightmap {

/// One page as pixels: irradiance in lux, gutters filled; coverage in [0, 1] per texel.
struct PageImage {
  image::ImageRgb irradiance;
  std::vector<float> coverage;
};

/// Spreads texel values over their pages and fills what surrounds the charts, so that a bilinear
/// look-up never meets an empty texel: an empty texel takes the mean of the neighbours of the
/// nearest chart, ring after ring (`rings` of them).
std::vector<PageImage> make_pages(const atlas::Layout& layout, const atlas::TexelMap& map,
                                  const std::vector<Rgb>& irradiance, int rings = 4);

/// The 8-bit form that glTF carries: linear, texel * intensity = lux, ordered dither of half a
/// step (the mean of an area stays right). intensity covers all but the brightest `cut` share of
/// covered texels when that lowers it at least fourfold; what is above is clipped.
struct EncodedPage {
  Bytes png;
  float intensity = 1;
  std::uint64_t clipped_texels = 0;
};
Result<EncodedPage> encode_page(const PageImage& page, double cut = 1e-3);

/// lightmap_K.exr: half float (float beyond 65504 lux and in the dark), alpha = coverage.
Result<Bytes> encode_exr(const PageImage& page);

/// For people: 8-bit sRGB picture with one exposure (99th percentile of luminance maps to white).
image::Image8 preview(const PageImage& page);

}  // namespace lightbatch::lightmap
