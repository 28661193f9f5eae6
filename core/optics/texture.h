#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/image/image.h"
#include "core/scene/scene.h"

namespace lightbatch::optics {

/// Look-up as glTF samplers magnify, bilinear or nearest: texel centres at half integers, wrap per
/// axis. A uv that is not finite reads as 0. Channels in [0, 1]; srgb decodes RGB (IEC 61966-2-1)
/// before filtering, alpha stays linear.
std::array<float, 4> sample_texture(const image::Image8& image, const scene::TextureSlot& slot,
                                    Vec2f uv, bool srgb);

/// uv after the slot's transform, before wrapping; finite where uv is, whatever the floats.
inline Vec2d transform_uv(const scene::TextureSlot& slot, Vec2f uv) {
  const Vec2d p{static_cast<double>(uv.x), static_cast<double>(uv.y)};
  return {static_cast<double>(slot.m00) * p.x + static_cast<double>(slot.m01) * p.y +
              static_cast<double>(slot.tu),
          static_cast<double>(slot.m10) * p.x + static_cast<double>(slot.m11) * p.y +
              static_cast<double>(slot.tv)};
}

/// Smallest and largest stored value of each channel over squares of 2^k texels: tells without
/// walking the texels whether an image varies under a triangle.
class TextureRange {
 public:
  explicit TextureRange(const image::Image8& image);

  struct Range {
    std::array<std::uint8_t, 4> lowest;
    std::array<std::uint8_t, 4> highest;
  };
  /// Conservative range over the box lower..upper of transformed uv, filter footprint included.
  Range over(const scene::TextureSlot& slot, Vec2d lower, Vec2d upper) const;

 private:
  struct Level {
    int width = 0;
    int height = 0;
    std::vector<Range> cells;
  };
  void add(int level, int x0, int y0, int x1, int y1, Range& range) const;
  std::vector<Level> levels_;
  int width_ = 0;
  int height_ = 0;
};

}  // namespace lightbatch::optics
