#pragma once

#include <array>

#include "core/math/vec.h"

namespace lightbatch::radiosity {

/// A triangle as seen from a point: uniform sampling of its solid angle (Arvo 1995, Stratified
/// Sampling of Spherical Triangles). Where a large triangle passes close by, nearly all that it
/// brings comes from a small part of its area, which area sampling would hardly ever find.
class SphericalTriangle {
 public:
  SphericalTriangle(const Vec3d& point, const std::array<Vec3f, 3>& corners);

  /// Steradians; 0 for a triangle seen edge-on or a point in its plane.
  double solid_angle() const { return solid_angle_; }
  /// Unit direction for random (a, b) in [0, 1)^2. Only when solid_angle() > 0.
  Vec3d direction(double a, double b) const;

 private:
  std::array<Vec3d, 3> towards_;  // unit
  double solid_angle_ = 0;
  double alpha_ = 0;   // angle at the first corner
  double cos_ab_ = 0;  // of the arc from the first to the second
};

}  // namespace lightbatch::radiosity
