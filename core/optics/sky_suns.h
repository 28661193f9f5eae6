#pragma once

#include <cstdint>
#include <vector>

#include "core/math/rgb.h"
#include "core/math/sampling.h"
#include "core/math/vec.h"
#include "core/optics/environment.h"

namespace lightbatch::optics {

/// A small part of a sky picture that is far brighter than the rest: light from far away whose
/// directions differ by a few degrees at most. Immutable; thread-safe.
class SkySun {
 public:
  /// A pixel of an equirectangular map (see Environment) and what it sends.
  struct Pixel {
    std::uint32_t x = 0, y = 0;
    Rgb luminance;  // nits
  };
  /// Of a map of the given size, pixels; at least one that is not black.
  SkySun(int width, int height, std::vector<Pixel> pixels);

  /// Unit, to the middle of its light.
  const Vec3f& towards() const { return towards_; }
  /// Irradiance on a surface that faces it, lux: the integral of luminance times direction, so that
  /// a surface that sees all of it receives exactly the cosine's part.
  const Rgb& illuminance() const { return illuminance_; }
  /// A direction to it (unit), as often as light comes from there. random in [0, 1).
  Vec3f direction(Vec2f random) const;

 private:
  int width_, height_;
  std::vector<Pixel> pixels_;
  DiscreteSampler sampler_;
  Vec3f towards_;
  Rgb illuminance_;
};

/// A sky and its suns apart.
struct SplitSky {
  Environment rest;
  std::vector<SkySun> suns;
};

/// Rays that are spread over the hemisphere seldom meet what is small and bright: what pixels have
/// beyond a multiple of the mean is taken out of the map. Skies that have nothing of the kind stay
/// as they are.
SplitSky split_suns(const Environment& sky);

}  // namespace lightbatch::optics
