#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/hierarchy/hierarchy.h"
#include "core/math/aabb.h"
#include "core/rays/caster.h"

namespace lightbatch::rays {

constexpr std::size_t kWidth = 8;

/// Reference to a child: a wide node, or a leaf of 1..8 triangles in one word.
struct Child {
  static constexpr std::uint32_t kLeafFlag = 0x80000000u;
  static constexpr std::uint32_t kMaxTriangles = 1u << 28;

  static std::uint32_t leaf(std::uint32_t first, std::uint32_t count) {
    return kLeafFlag | ((count - 1) << 28) | first;
  }
  static bool is_leaf(std::uint32_t word) { return (word & kLeafFlag) != 0; }
  static std::uint32_t count(std::uint32_t word) { return ((word >> 28) & 7u) + 1; }
  static std::uint32_t first(std::uint32_t word) { return word & (kMaxTriangles - 1); }
};

/// Eight child boxes side by side. Unused places hold empty boxes, which no ray meets.
struct alignas(64) WideNode {
  float lower[3][kWidth];
  float upper[3][kWidth];
  std::uint32_t child[kWidth];
};

/// The casting tree: the binary hierarchy with levels taken out. Triangles are stored leaf by leaf:
/// component j of triangle i of a leaf is corners[9 * first + j * count + i] (corner j / 3, axis
/// j % 3), so vector loads need no padding between leaves.
struct WideTree {
  static constexpr std::uint32_t kFilteredFlag = 0x80000000u;

  bool empty = true;
  std::uint32_t root = 0;
  Vec3f reach;  // largest |coordinate| of the boxes on each axis
  std::vector<WideNode> nodes;
  std::vector<float> corners;      // 9 a triangle, and 8 of padding
  std::vector<std::uint32_t> ids;  // triangle index, kFilteredFlag where it asks the filter

  std::size_t memory_bytes() const {
    return nodes.capacity() * sizeof(WideNode) + corners.capacity() * sizeof(float) +
           ids.capacity() * sizeof(std::uint32_t);
  }
};

WideTree collapse(const hierarchy::Hierarchy& tree, std::span<const Vec3f> positions,
                  std::span<const std::array<std::uint32_t, 3>> triangles,
                  std::span<const Surface> surfaces);

}  // namespace lightbatch::rays
