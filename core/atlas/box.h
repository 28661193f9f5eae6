#pragma once

#include <vector>

#include "core/math/vec.h"

namespace lightbatch::atlas {

/// A rectangle: points p with lower <= (dot(p, axis), cross(axis, p)) <= lower + size.
struct Box {
  Vec2d axis{1, 0};  // unit
  Vec2d lower, size;
};

/// The rectangle of smallest area around the points (which are sorted in place). Rotating
/// calipers, Shamos 1978, on the convex hull, Andrew 1979. Ties: the first hull edge.
Box smallest_box(std::vector<Vec2d>& points);

}  // namespace lightbatch::atlas
