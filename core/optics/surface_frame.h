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

/// How far ray origins are lifted at the far ends of the scene; coincident surfaces then lie safely
/// behind. Nearer to its middle `lift_near` takes less.
inline float lift_of(const scene::Scene& scene) {
  const float largest = std::max(magnitude(scene.box.lower), magnitude(scene.box.upper));
  return std::isfinite(largest) ? kRoundingOfMix * largest : 0.0f;
}

/// Between what a place's own coordinates round by (`reach`: its magnitude) and what the scene's
/// do, whose surfaces may have corners far away: the geometric mean, so that a lamp's housing of a
/// centimetre stays closed on a ground of 100 km.
inline float lift_near(float reach, float lift) {
  return std::min(lift, std::sqrt(kRoundingOfMix * reach * lift));
}

/// A triangle, made once for the frames of many of its points.
class TriangleFrame {
 public:
  TriangleFrame(const scene::Scene& scene, std::uint32_t triangle) {
    const auto c = scene.corners(triangle);
    corner_ = c[0];
    reach_ = std::max({magnitude(c[0]), magnitude(c[1]), magnitude(c[2])});
    e1_ = c[1] - c[0];
    e2_ = c[2] - c[0];
    const Vec3d n = cross(to_double(e1_), to_double(e2_));
    const double size = length(n);
    normal_ = size > 0 ? to_float(n * (1.0 / size)) : Vec3f{0, 0, 1};
  }

  /// lift: of the scene.
  SurfaceFrame at(float u, float v, bool back, float lift) const {
    SurfaceFrame frame;
    frame.normal = back ? -normal_ : normal_;
    frame.position = corner_ + e1_ * u + e2_ * v;
    frame.origin = frame.position + frame.normal * lift_near(reach_, lift);
    return frame;
  }

 private:
  Vec3f corner_, e1_, e2_;
  Vec3f normal_;  // of the front
  float reach_ = 0;
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
  const float lift = lift_near(magnitude(lamp), scene_lift);
  const float distance = length(to);
  return 1.0f - (distance > lift ? std::max(kRounding, lift / distance) : 1.0f);
}

}  // namespace lightbatch::optics
