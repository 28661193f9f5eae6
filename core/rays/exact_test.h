#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/math/vec.h"

namespace lightbatch::rays {

/// The ray-triangle predicate that decides every answer; faster filters may only skip it where they
/// are certain of its outcome, so all code paths give the same hits bit for bit.
///
/// S. Woop, C. Benthin, I. Wald: Watertight Ray/Triangle Intersection, JCGT 2(1), 2013. The ray is
/// made the z axis by a shear; three edge functions decide. Deviations: all in double, and the sign
/// of an edge function is that of the exact determinant of the sheared corners, so triangles that
/// share corners form a consistent planar mesh around the ray: no ray passes between them.
class ExactTest {
 public:
  ExactTest(const Vec3f& origin, const Vec3f& direction) {
    const Vec3d d = to_double(direction);
    kz_ = std::abs(d.x) > std::abs(d.y) ? (std::abs(d.x) > std::abs(d.z) ? 0u : 2u)
                                        : (std::abs(d.y) > std::abs(d.z) ? 1u : 2u);
    kx_ = (kz_ + 1) % 3;
    ky_ = (kz_ + 2) % 3;
    if (d[kz_] < 0) std::swap(kx_, ky_);
    sx_ = d[kx_] / d[kz_];
    sy_ = d[ky_] / d[kz_];
    dz_ = d[kz_];
    ox_ = static_cast<double>(origin[kx_]);
    oy_ = static_cast<double>(origin[ky_]);
    oz_ = static_cast<double>(origin[kz_]);
  }

  struct Result {
    bool hit = false;
    bool back = false;
    float t = 0;
    float u = 0;
    float v = 0;
  };

  /// Corners as nine floats at `p`, `step` floats apart. The caller checks the range of t.
  Result operator()(const float* p, std::size_t step) const {
    const Corner a = sheared(p, step);
    const Corner b = sheared(p + 3 * step, step);
    const Corner c = sheared(p + 6 * step, step);
    const double u = edge(c, b), v = edge(a, c), w = edge(b, a);
    const bool some_below = std::min(u, std::min(v, w)) < 0;
    const bool some_above = std::max(u, std::max(v, w)) > 0;
    if (some_below == some_above) return {};  // outside, or seen edge-on
    const double det = u + v + w;
    if (det == 0) return {};
    const double t = (u * a.z + v * b.z + w * c.z) / (det * dz_);
    return {true, some_below, static_cast<float>(t), static_cast<float>(v / det),
            static_cast<float>(w / det)};
  }

 private:
  struct Corner {
    double x, y, z;
  };
  Corner sheared(const float* p, std::size_t step) const {
    const double z = static_cast<double>(p[kz_ * step]) - oz_;
    return {static_cast<double>(p[kx_ * step]) - ox_ - sx_ * z,
            static_cast<double>(p[ky_ * step]) - oy_ - sy_ * z, z};
  }

  // Of the sign of the exact determinant: rounding is monotone, so different products differ as the
  // exact ones do, and so does their difference; equal ones are told apart by their rounding
  // errors, which fma gives exactly.
  static double edge(const Corner& p, const Corner& q) {
    const double left = p.x * q.y;
    const double right = p.y * q.x;
    if (left != right) return left - right;
    return std::fma(p.x, q.y, -left) - std::fma(p.y, q.x, -right);
  }

  std::size_t kx_ = 0, ky_ = 0, kz_ = 0;
  double ox_, oy_, oz_;
  double sx_ = 0, sy_ = 0, dz_ = 1;
};

}  // namespace lightbatch::rays
