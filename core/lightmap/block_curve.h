#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/lightmap/blocks.h"
#include "core/lightmap/smooth.h"

namespace lightbatch::lightmap {

/// Of a block's corners (x0 y0, x1 y0, x0 y1, x1 y1), in a bilinear mean at a texel; sum 1.
inline std::array<float, 4> corner_shares(const Block& b, int x, int y) {
  const auto along = [](int first, int last, int at) {
    return last > first ? static_cast<float>(at - first) / static_cast<float>(last - first) : 0;
  };
  const float s = along(b.x0, b.x1, x), t = along(b.y0, b.y1, y);
  return {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t};
}

/// What the middle of a block is off its corners' mean by, lux, and the variance of that, pooled:
/// a single texel's is rough.
struct MiddleOff {
  Rgb lux;
  float variance = 0;
};
inline MiddleOff middle_off(std::span<const GatheredTexel> texels,
                            const std::array<std::uint32_t, 4>& corner, std::uint32_t middle,
                            const std::array<float, 4>& share) {
  MiddleOff off{texels[middle].irradiance, texels[middle].variance};
  for (std::size_t i = 0; i < 4; ++i) {
    off.lux += texels[corner[i]].irradiance * -share[i];
    off.variance += texels[corner[i]].variance;
  }
  off.variance *= (1 + 0.25f) / 5;
  return off;
}

/// Bends a bilinear mean to what the middle tells of curvature: along a wall or above a floor light
/// bends the same way in block after block, and a mean of corners is too bright, or too dark, in
/// all of them.
class BlockCurve {
 public:
  /// at_middle: the corners' shares there. What noise alone makes is taken for half.
  BlockCurve(const MiddleOff& off, const std::array<float, 4>& at_middle) : at_middle_(at_middle) {
    const float square = off.lux.sum() * off.lux.sum() / 9;
    const float whole = square + off.variance, top = bump(at_middle);
    // Squares of light beyond 1e19 lux are no floats.
    bend_ = whole > 0 && std::isfinite(whole) && top > 0 ? square / whole / top : 0;
  }

  /// Bends less where light would fall below 0: of the corners and the middle, each kind apart.
  template <typename LightOf>
  void keep_positive(const std::array<std::uint32_t, 4>& corner, std::uint32_t middle,
                     LightOf light_of) {
    Rgb off = light_of(middle), least = light_of(corner[0]);
    for (std::size_t i = 0; i < 4; ++i) {
      const Rgb light = light_of(corner[i]);
      off += light * -at_middle_[i];
      least = {std::min(least.r, light.r), std::min(least.g, light.g), std::min(least.b, light.b)};
    }
    const auto keep = [&](float low, float by) {
      if (by * bend_ * kHighest >= -low) return;
      // The faintest light has no half.
      bend_ = low > 0 ? std::min(bend_, low / (-by * kHighest)) : 0;
    };
    keep(least.r, off.r);
    keep(least.g, off.g);
    keep(least.b, off.b);
  }

  /// The middle's share at a place, of which the corners' are changed so that all sum to 1.
  float of_middle(std::array<float, 4>& share) const {
    const float middle = bend_ * bump(share);
    for (std::size_t i = 0; i < 4; ++i) share[i] -= middle * at_middle_[i];
    return middle;
  }

 private:
  /// A paraboloid that is 0 in the corners: what even curvature is off the bilinear mean by.
  static float bump(const std::array<float, 4>& share) {
    const float s = share[1] + share[3], t = share[2] + share[3];
    return s * (1 - s) + t * (1 - t);
  }

  static constexpr float kHighest = 0.5f;  // of the paraboloid

  std::array<float, 4> at_middle_;
  float bend_ = 0;
};

}  // namespace lightbatch::lightmap
