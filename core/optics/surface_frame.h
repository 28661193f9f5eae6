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

/// How far ray origins are lifted: positions are recentred floats, so a mix of three corners is
/// within 4 ulp of the largest coordinate; coincident surfaces then lie safely behind.
inline float lift_of(const scene::Scene& scene) {
  float largest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    largest =
        std::max({largest, std::fabs(scene.box.lower[axis]), std::fabs(scene.box.upper[axis])});
  }
  return std::isfinite(largest) ? 1e-6f * largest : 0.0f;
}

/// A triangle, made once for the frames of many of its points.
class TriangleFrame {
 public:
  TriangleFrame(const scene::Scene& scene, std::uint32_t triangle) {
    const auto c = scene.corners(triangle);
    corner_ = c[0];
    e1_ = c[1] - c[0];
    e2_ = c[2] - c[0];
    const Vec3d n = cross(to_double(e1_), to_double(e2_));
    const double size = length(n);
    normal_ = size > 0 ? to_float(n * (1.0 / size)) : Vec3f{0, 0, 1};
  }

  SurfaceFrame at(float u, float v, bool back, float lift) const {
    SurfaceFrame frame;
    frame.normal = back ? -normal_ : normal_;
    frame.position = corner_ + e1_ * u + e2_ * v;
    frame.origin = frame.position + frame.normal * lift;
    return frame;
  }

 private:
  Vec3f corner_, e1_, e2_;
  Vec3f normal_;  // of the front
};

inline SurfaceFrame surface_frame(const scene::Scene& scene, std::uint32_t triangle, float u,
                                  float v, bool back, float lift) {
  return TriangleFrame(scene, triangle).at(u, v, back, lift);
}

/// Where a shadow ray along `to` ends, as a share of it: short of its end by as much as origins are
/// lifted, and by the rounding of t at least, so that no plane that a lamp lies in shadows it.
inline float shadow_end(const Vec3f& to, float lift) {
  constexpr float kRounding = 4e-7f;
  const float distance = length(to);
  return 1.0f - (distance > lift ? std::max(kRounding, lift / distance) : 1.0f);
}

}  // namespace lightbatch::optics
