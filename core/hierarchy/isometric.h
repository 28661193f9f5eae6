#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/math/aabb.h"

namespace lightbatch::hierarchy {

/// The view of the level drawings: from (1, 1, 1), +y up, fitted into a picture with a margin.
class Isometric {
 public:
  struct Point {
    double x, y;   // pixels, y down
    double depth;  // larger is nearer to the viewer
  };
  /// The three visible faces of a box: toward +x, +y and +z.
  static constexpr int kFaces = 3;
  using Face = std::array<Point, 4>;

  Isometric(std::span<const Aabb> boxes, int width, int height) {
    double low_x = 0, high_x = 0, low_y = 0, high_y = 0;
    bool first = true;
    for (const Aabb& box : boxes) {
      for (int corner = 0; corner < 8; ++corner) {
        const Point p = turned(pick(box, corner));
        low_x = first ? p.x : std::min(low_x, p.x);
        high_x = first ? p.x : std::max(high_x, p.x);
        low_y = first ? p.y : std::min(low_y, p.y);
        high_y = first ? p.y : std::max(high_y, p.y);
        first = false;
      }
    }
    constexpr double kMargin = 0.04;
    const double span_x = high_x - low_x, span_y = high_y - low_y;
    const double w = width * (1 - 2 * kMargin), h = height * (1 - 2 * kMargin);
    scale_ = 1;
    if (span_x > 0 || span_y > 0)
      scale_ = std::min(w / std::max(span_x, 1e-300), h / std::max(span_y, 1e-300));
    if (!std::isfinite(scale_)) scale_ = 1;
    shift_x_ = width * 0.5 - scale_ * (low_x + high_x) * 0.5;
    shift_y_ = height * 0.5 - scale_ * (low_y + high_y) * 0.5;
  }

  Face face(const Aabb& box, int axis) const {
    // Corners as bits x, y, z; each face has its own axis at the upper end.
    static constexpr int kCorners[kFaces][4] = {{1, 3, 7, 5}, {2, 6, 7, 3}, {4, 5, 7, 6}};
    Face result;
    for (std::size_t k = 0; k < 4; ++k) {
      Point p = turned(pick(box, kCorners[axis][k]));
      result[k] = {p.x * scale_ + shift_x_, p.y * scale_ + shift_y_, p.depth};
    }
    return result;
  }

 private:
  static Vec3d pick(const Aabb& box, int corner) {
    return to_double(Vec3f{(corner & 1) != 0 ? box.upper.x : box.lower.x,
                           (corner & 2) != 0 ? box.upper.y : box.lower.y,
                           (corner & 4) != 0 ? box.upper.z : box.lower.z});
  }
  static Point turned(const Vec3d& p) {
    static const double kHalf = std::sqrt(0.5), kSixth = std::sqrt(1.0 / 6),
                        kThird = std::sqrt(1.0 / 3);
    return {(p.x - p.z) * kHalf, (p.x - 2 * p.y + p.z) * kSixth, (p.x + p.y + p.z) * kThird};
  }
  double scale_ = 1, shift_x_ = 0, shift_y_ = 0;
};

}  // namespace lightbatch::hierarchy
