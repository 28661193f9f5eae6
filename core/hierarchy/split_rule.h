#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "core/math/aabb.h"

namespace lightbatch::hierarchy {

/// No leaf lies deeper than this (the root has depth 0), whatever the input: below the depth where
/// it could happen, positions that would leave a child too large for the levels left are passed
/// over. 2^30 primitives always fit.
constexpr int kMaxDepth = 128;

/// Leaves of up to so many primitives are what the cost of a tree reckons with where that is less:
/// casting trees have such leaves.
constexpr std::uint32_t kMergedLeaf = 8;

/// Half the surface area, in the one order of operations that every builder uses.
inline float half_area(float dx, float dy, float dz) { return dx * dy + dy * dz + dz * dx; }
inline float half_area(const Aabb& box) {
  return half_area(box.upper.x - box.lower.x, box.upper.y - box.lower.y, box.upper.z - box.lower.z);
}
/// Twice the box centre on an axis, the sort key. Adding 0 makes -0 and 0 one key.
inline float centre_key(const Aabb& box, std::size_t axis) {
  return (box.lower[axis] + box.upper[axis]) + 0.0f;
}

/// Positions (number of primitives on the left) that a node of n primitives at `depth` may use.
struct PositionRange {
  std::uint32_t first;
  std::uint32_t last;
};
inline PositionRange allowed_positions(std::uint32_t n, int depth) {
  const int levels = kMaxDepth - depth - 1;
  const std::uint32_t room = levels >= 30 ? n - 1 : std::min(n - 1, 1u << std::max(levels, 0));
  return {n - room, room};
}

/// Order among equal costs: positions near the middle first, the left half before the right. It
/// keeps the depth logarithmic for identical boxes, where every position costs the same.
inline std::uint32_t tie_rank(std::uint32_t position, std::uint32_t n) {
  return position <= n / 2 ? n / 2 - position : position;
}

/// The cheapest split seen. Ties: lower tie_rank, then lower axis. Starts at the middle on axis 0,
/// which stays when no cost is finite.
struct Split {
  float cost = std::numeric_limits<float>::infinity();
  std::uint32_t axis = 0;
  std::uint32_t position = 0;
  std::uint32_t rank = 0;

  static Split middle(std::uint32_t n) { return {.position = n / 2}; }
  void offer(float new_cost, std::uint32_t new_axis, std::uint32_t new_position,
             std::uint32_t new_rank) {
    const bool better =
        new_cost < cost ||
        (new_cost == cost && (new_rank < rank || (new_rank == rank && new_axis < axis)));
    if (better) *this = {new_cost, new_axis, new_position, new_rank};
  }
};

}  // namespace lightbatch::hierarchy
