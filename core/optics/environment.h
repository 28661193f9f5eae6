#pragma once

#include <cstdint>
#include <memory>

#include "core/image/image.h"
#include "core/math/rgb.h"
#include "core/math/sampling.h"
#include "core/math/vec.h"

namespace lightbatch::optics {

constexpr double kMostRadiance = 1e30;  // nits; keeps every product of light finite

/// What lies beyond the scene: black, one luminance everywhere, or an equirectangular map; nits.
///
/// Map: +Y up, row 0 at the zenith, u = atan2(z, x) / (2 pi) + 1/2 (the middle of the picture is
/// +X; as three.js, and as Blender after its change of axes), constant over each pixel. Values that
/// are negative or not finite count as 0, those beyond kMostRadiance as that. Immutable;
/// copies share the map; thread-safe.
class Environment {
 public:
  Environment() = default;
  explicit Environment(const Rgb& radiance);
  explicit Environment(image::ImageRgb map, float scale = 1);

  bool is_black() const { return mean_.is_black(); }
  bool is_uniform() const { return map_ == nullptr; }
  /// Null where it is uniform.
  const image::ImageRgb* map() const { return map_.get(); }
  /// From the direction the light comes from (unit).
  Rgb radiance(const Vec3f& direction) const;
  /// Mean over the sphere.
  const Rgbd& mean() const { return mean_; }

  struct Sample {
    Vec3f direction;  // towards the light
    Rgb radiance;
    double density = 0;  // per steradian, > 0
  };
  /// A direction with density about in proportion to radiance. The environment must not be black.
  Sample sample(double random_a, double random_b) const;
  /// Density with which sample() gives this direction, per steradian.
  double density(const Vec3f& direction) const;

 private:
  struct Pixel {
    int x, y;
  };
  Pixel pixel(const Vec3f& direction) const;
  double solid_angle(int block_row, int block_column) const;

  Rgb uniform_;
  Rgbd mean_;
  std::shared_ptr<const image::ImageRgb> map_;
  // Sampling works on blocks of block_ x block_ pixels, at most about 1024 x 512 of them.
  int block_ = 1;
  int columns_ = 0;
  DiscreteSampler sampler_;
};

}  // namespace lightbatch::optics
