#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "core/math/vec.h"
#include "core/scene/scene.h"

namespace lightbatch::optics {

/// A point on one side of a triangle, ready to cast rays from.
struct SurfaceFrame {
  Vec3f position;
  Vec3f normal;  // unit, of the chosen side
  Vec3f origin;  // position lifted off the plane by the rounding error of positions
};

/// Off a surface by the rounding of what lies on it: positions are recentred floats, so a mix of
/// three corners is within 4 ulp of the largest coordinate.
constexpr float kRoundingOfMix = 1e-6f;

/// The largest coordinate, as a distance from the origin of the recentred scene.
inline float magnitude(const Vec3f& p) {
  return std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
}

/// How far ray origins are lifted, but for small triangles: by what positions of the scene round
/// by, since surfaces with corners far away round so anywhere; coincident ones then lie safely
/// behind.
inline float lift_of(const scene::Scene& scene) {
  const float largest = std::max(magnitude(scene.box.lower), magnitude(scene.box.upper));
  return std::isfinite(largest) ? kRoundingOfMix * largest : 0.0f;
}

/// Of a small triangle's size, that its points are lifted at most, unless they round by more: a
/// housing of a few centimetres stays closed on a ground of 100 km.
constexpr float kLiftOfSize = 1e-3f;

/// At a lamp: between what its own position rounds by and what the scene's do, the geometric mean.
inline float lift_at_lamp(const Vec3f& lamp, float scene_lift) {
  return std::min(scene_lift, std::sqrt(kRoundingOfMix * magnitude(lamp) * scene_lift));
}

/// A triangle, made once for the frames of many of its points.
class TriangleFrame {
 public:
  TriangleFrame(const scene::Scene& scene, std::uint32_t triangle) {
    const auto c = scene.corners(triangle);
    corner_ = c[0];
    e1_ = c[1] - c[0];
    e2_ = c[2] - c[0];
    const float reach = std::max({magnitude(c[0]), magnitude(c[1]), magnitude(c[2])});
    const float edge = std::max(magnitude(e1_), magnitude(e2_));
    most_lift_ = std::max(kRoundingOfMix * reach, kLiftOfSize * edge);
    const Vec3d n = cross(to_double(e1_), to_double(e2_));
    const double size = length(n);
    normal_ = size > 0 ? to_float(n * (1.0 / size)) : Vec3f{0, 0, 1};
  }

  /// lift: of the scene.
  SurfaceFrame at(float u, float v, bool back, float lift) const {
    SurfaceFrame frame;
    frame.normal = back ? -normal_ : normal_;
    frame.position = corner_ + e1_ * u + e2_ * v;
    frame.origin = frame.position + frame.normal * std::min(lift, most_lift_);
    return frame;
  }

 private:
  Vec3f corner_, e1_, e2_;
  Vec3f normal_;  // of the front
  float most_lift_ = 0;
};

inline SurfaceFrame surface_frame(const scene::Scene& scene, std::uint32_t triangle, float u,
                                  float v, bool back, float lift) {
  return TriangleFrame(scene, triangle).at(u, v, back, lift);
}

/// Where a shadow ray along `to`, to a lamp, ends, as a share of it: short of its end by as much as
/// an origin there is lifted, and by the rounding of t at least, so that no plane that a lamp lies
/// in shadows it. scene_lift: of the scene.
inline float shadow_end(const Vec3f& to, const Vec3f& lamp, float scene_lift) {
  constexpr float kRounding = 4e-7f;
  const float lift = lift_at_lamp(lamp, scene_lift);
  const float distance = length(to);
  return 1.0f - (distance > lift ? std::max(kRounding, lift / distance) : 1.0f);
}

}  // namespace lightbatch::optics
