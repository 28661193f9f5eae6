#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/hierarchy/hierarchy.h"

namespace lightbatch::hierarchy {

/// What builders write and Hierarchy is made from: depth-first places (left child of i is i + 1,
/// right child is i + 2 * count(i + 1)), tight boxes, and the primitives in leaf order.
struct TreeArrays {
  std::vector<Aabb> boxes;                // 2n - 1
  std::vector<std::uint32_t> counts;      // 2n - 1
  std::vector<std::uint32_t> primitives;  // n

  explicit TreeArrays(std::size_t n = 0)
      : boxes(n == 0 ? 0 : 2 * n - 1), counts(boxes.size()), primitives(n) {}
};

/// Gives Hierarchy its contents.
class HierarchyBuilder {
 public:
  static Hierarchy finish(TreeArrays&& arrays);
};

/// The founding algorithm in plain scalar code: the reference that faster builders equal bit for
/// bit. n >= 1.
TreeArrays sweep_scalar(std::span<const Aabb> boxes);

}  // namespace lightbatch::hierarchy
