#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/math/vec.h"

namespace lightbatch {

constexpr float kPi = 3.14159265358979323846f;
constexpr double kPiDouble = 3.14159265358979323846;

/// Right-handed orthonormal frame about a unit normal.
struct Frame {
  Vec3f x, y, z;

  Vec3f to_world(const Vec3f& v) const { return x * v.x + y * v.y + z * v.z; }
  Vec3f to_local(const Vec3f& v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }

  /// Duff et al. 2017, Building an Orthonormal Basis, Revisited. n must be unit.
  static Frame about(const Vec3f& n) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    return {
        {1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
  }
};

/// Concentric map of the unit square to the unit disc (Shirley and Chiu 1997): area-preserving,
/// keeps strata compact. Sine and cosine are polynomials (error < 2e-7): the same with any libm.
inline Vec2f concentric_disc(const Vec2f& square) {
  const float a = 2 * square.x - 1;
  const float b = 2 * square.y - 1;
  const bool first = a * a > b * b;
  const float radius = first ? a : b;
  if (radius == 0) return {0, 0};
  const float angle = (first ? b / a : a / b) * (kPi / 4);
  const float s = angle * angle;
  const float sine =
      angle * (1 + s * (-1.0f / 6 + s * (1.0f / 120 + s * (-1.0f / 5040 + s * (1.0f / 362880)))));
  const float cosine =
      1 + s * (-1.0f / 2 + s * (1.0f / 24 + s * (-1.0f / 720 + s * (1.0f / 40320))));
  return first ? Vec2f{radius * cosine, radius * sine} : Vec2f{radius * sine, radius * cosine};
}

/// Direction about +z with density cos / pi (Malley). z > 0 always.
inline Vec3f cosine_hemisphere(const Vec2f& square) {
  const Vec2f d = concentric_disc(square);
  const float z = std::sqrt(std::max(1e-12f, 1 - d.x * d.x - d.y * d.y));
  return {d.x, d.y, z};
}

/// Direction about +z, uniform over the upper half of the sphere (density 1 / 2 pi). z > 0 always.
/// The concentric disc lifted by Lambert's equal-area map.
inline Vec3f uniform_hemisphere(const Vec2f& square) {
  const Vec2f d = concentric_disc(square);
  const float squared = d.x * d.x + d.y * d.y;
  const float stretch = std::sqrt(std::max(0.0f, 2 - squared));
  return {d.x * stretch, d.y * stretch, std::max(1e-6f, 1 - squared)};
}

/// Direction uniform over the sphere (density 1 / 4 pi): two halves side by side in x.
inline Vec3f uniform_sphere(const Vec2f& square) {
  const bool lower = square.x >= 0.5f;
  Vec3f d = uniform_hemisphere({2 * square.x - (lower ? 1.0f : 0.0f), square.y});
  if (lower) d.z = -d.z;
  return d;
}

/// Barycentric (u, v) of a uniform point of a triangle (Heitz 2019, a low-distortion map).
inline Vec2f uniform_triangle(Vec2f square) {
  if (square.y > square.x) {
    square.x *= 0.5f;
    square.y -= square.x;
  } else {
    square.y *= 0.5f;
    square.x -= square.y;
  }
  return square;
}

/// Weight of a sample of technique a (count_a samples of density a) beside technique b; Veach 1997.
/// The weights of the two techniques for one point sum to 1.
inline double balance_heuristic(double count_a, double a, double count_b, double b) {
  const double wa = count_a * a;
  const double wb = count_b * b;
  return wa > 0 ? wa / (wa + wb) : 0;
}
inline double power_heuristic(double count_a, double a, double count_b, double b) {
  if (!(count_a * a > 0)) return 0;
  const double ratio = count_b * b / (count_a * a);
  return 1 / (1 + ratio * ratio);
}

/// Picks an item with probability proportional to its weight. Monotone in the random number, so
/// strata survive; a guide table (Chen and Asau 1974) makes a pick O(1) on average.
class DiscreteSampler {
 public:
  struct Pick {
    std::uint32_t index = 0;
    double probability = 0;
    double rest = 0;  // the random number within the item, uniform in [0, 1)
  };

  DiscreteSampler() = default;
  /// Weights are finite and >= 0; items of weight 0 are never picked.
  explicit DiscreteSampler(std::span<const double> weights) : cumulative_(weights.size()) {
    for (std::size_t i = 0; i < weights.size(); ++i) {
      total_ += weights[i];
      cumulative_[i] = total_;
    }
    guide_.resize(weights.size());
    std::uint32_t item = 0;
    for (std::size_t slot = 0; slot < guide_.size(); ++slot) {
      const double level =
          total_ * (static_cast<double>(slot) / static_cast<double>(guide_.size()));
      while (item + 1 < cumulative_.size() && cumulative_[item] <= level) ++item;
      guide_[slot] = item;
    }
  }

  bool is_empty() const { return !(total_ > 0); }
  double total() const { return total_; }
  double probability(std::size_t i) const {
    return total_ > 0 ? (cumulative_[i] - (i > 0 ? cumulative_[i - 1] : 0)) / total_ : 0;
  }

  /// random in [0, 1); the sampler must not be empty.
  Pick pick(double random) const {
    const double level = random * total_;
    const std::size_t slot = std::min(
        guide_.size() - 1, static_cast<std::size_t>(random * static_cast<double>(guide_.size())));
    std::size_t i = guide_[slot];
    while (i > 0 && cumulative_[i - 1] > level) --i;
    while (i + 1 < cumulative_.size() && cumulative_[i] <= level) ++i;
    while (i > 0 && width(i) == 0) --i;
    const double w = width(i);
    const double below = i > 0 ? cumulative_[i - 1] : 0;
    return {static_cast<std::uint32_t>(i), w / total_,
            std::clamp((level - below) / w, 0.0, 0x1.fffffffffffffp-1)};
  }

 private:
  double width(std::size_t i) const { return cumulative_[i] - (i > 0 ? cumulative_[i - 1] : 0); }

  std::vector<double> cumulative_;
  std::vector<std::uint32_t> guide_;
  double total_ = 0;
};

}  // namespace lightbatch
