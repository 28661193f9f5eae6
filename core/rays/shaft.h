#pragma once

#include <cstddef>

#include "core/math/aabb.h"

namespace lightbatch::rays {

/// The convex hull of two boxes: its bounds, and the planes that join an edge of one box to the
/// parallel edge of the other (E. Haines, J. Wallace: Shaft Culling for Efficient Ray-Cast
/// Radiosity, 1991). Each plane is parallel to one axis. All are moved outward by `slack`.
struct Shaft {
  static constexpr std::size_t kMost = 16;  // candidates that are worth gathering

  struct Plane {
    std::size_t axis[2];
    float normal[2];
    float limit;  // inside: normal . p <= limit
  };

  Shaft(const Aabb& a, const Aabb& b, float slack);

  Aabb bounds;
  Plane planes[12];
  std::size_t plane_count = 0;
};

}  // namespace lightbatch::rays
