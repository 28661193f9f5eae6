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

inline SurfaceFrame surface_frame(const scene::Scene& scene, std::uint32_t triangle, float u,
                                  float v, bool back, float lift) {
  const auto c = scene.corners(triangle);
  const Vec3f e1 = c[1] - c[0];
  const Vec3f e2 = c[2] - c[0];
  const Vec3d n = cross(to_double(e1), to_double(e2));
  const double size = length(n);
  SurfaceFrame frame;
  frame.normal = size > 0 ? to_float(n * ((back ? -1.0 : 1.0) / size)) : Vec3f{0, 0, 1};
  frame.position = c[0] + e1 * u + e2 * v;
  frame.origin = frame.position + frame.normal * lift;
  return frame;
}

/// Where a shadow ray along `to` ends, as a share of it: short of its end by as much as origins are
/// lifted, and by the rounding of t at least, so that no plane that a lamp lies in shadows it.
inline float shadow_end(const Vec3f& to, float lift) {
  constexpr float kRounding = 4e-7f;
  const float distance = length(to);
  return 1.0f - (distance > lift ? std::max(kRounding, lift / distance) : 1.0f);
}

}  // namespace lightbatch::optics
