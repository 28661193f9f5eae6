#pragma once

#include <array>

#include "core/math/vec.h"

namespace lightbatch {

/// Affine transform in double: columns x, y, z are the images of the axes, t the translation.
/// Transforms of a scene are composed in double; only recentred positions become float.
struct Affine {
  Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, t{0, 0, 0};

  Vec3d vector(const Vec3d& v) const { return x * v.x + y * v.y + z * v.z; }
  Vec3d point(const Vec3d& p) const { return vector(p) + t; }
  /// Applies `inner` first.
  Affine operator*(const Affine& inner) const {
    return {vector(inner.x), vector(inner.y), vector(inner.z), point(inner.t)};
  }
  /// Negative: the transform mirrors, and front faces flip their winding.
  double determinant() const { return dot(cross(x, y), z); }
  /// Direction of a transformed normal (adjugate transpose; right for any non-singular transform,
  /// mirrored ones too; not normalised).
  Vec3d normal(const Vec3d& n) const {
    const double sign = determinant() < 0 ? -1.0 : 1.0;
    return (cross(y, z) * n.x + cross(z, x) * n.y + cross(x, y) * n.z) * sign;
  }
  bool operator==(const Affine&) const = default;

  /// glTF column-major 4x4 matrix (the last row is taken as 0 0 0 1).
  static Affine from_column_major(const std::array<double, 16>& m) {
    return {{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}, {m[12], m[13], m[14]}};
  }
  /// Translation * rotation (unit quaternion x, y, z, w; normalised here) * scale.
  static Affine from_trs(const Vec3d& translation, const std::array<double, 4>& quaternion,
                         const Vec3d& scale) {
    double qx = quaternion[0], qy = quaternion[1], qz = quaternion[2], qw = quaternion[3];
    const double norm = std::sqrt(qx * qx + qy * qy + qz * qz + qw * qw);
    if (norm > 0) {
      qx /= norm;
      qy /= norm;
      qz /= norm;
      qw /= norm;
    } else {
      qw = 1;
    }
    Affine m;
    m.x = Vec3d{1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy + qz * qw), 2 * (qx * qz - qy * qw)} *
          scale.x;
    m.y = Vec3d{2 * (qx * qy - qz * qw), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz + qx * qw)} *
          scale.y;
    m.z = Vec3d{2 * (qx * qz + qy * qw), 2 * (qy * qz - qx * qw), 1 - 2 * (qx * qx + qy * qy)} *
          scale.z;
    m.t = translation;
    return m;
  }
};

}  // namespace lightbatch
