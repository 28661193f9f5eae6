#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/hierarchy/hierarchy.h"

namespace lightbatch::hierarchy {

/// What builders write and Hierarchy is made from: depth-first places (left child of i is i + 1,
/// right child is i + 2 * count(i + 1)), tight boxes, and the primitives in leaf order. Starts
/// uninitialised.
struct TreeArrays {
  TreeNodes nodes;                        // 2n - 1
  LargeVector<std::uint32_t> primitives;  // n

  explicit TreeArrays(std::size_t n = 0) : nodes(n == 0 ? 0 : 2 * n - 1), primitives(n) {}
};

/// Gives Hierarchy its contents.
class HierarchyBuilder {
 public:
  static Hierarchy finish(TreeArrays&& arrays);
};

}  // namespace lightbatch::hierarchy
