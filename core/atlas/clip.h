#pragma once

#include <array>
#include <cstddef>

#include "core/math/vec.h"

namespace lightbatch::atlas {

/// A convex polygon of at most seven corners: a triangle cut by four lines.
struct Polygon {
  std::array<Vec2d, 8> corners;
  std::size_t count = 0;

  void add(const Vec2d& p) { corners[count++] = p; }
};

/// The part where sign * coordinate >= sign * bound (coordinate: x, or y when `vertical`).
/// Sutherland and Hodgman 1974.
Polygon clipped(const Polygon& polygon, bool vertical, double bound, double sign);

/// Unsigned area and centroid (of the corners' mean when the area is 0).
struct AreaCentroid {
  double area = 0;
  Vec2d centroid;
};
AreaCentroid area_centroid(const Polygon& polygon);

}  // namespace lightbatch::atlas
