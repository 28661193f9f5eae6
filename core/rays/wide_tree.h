#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/hierarchy/hierarchy.h"
#include "core/hierarchy/large_vector.h"
#include "core/math/aabb.h"
#include "core/rays/caster.h"
#include "core/rays/grid.h"

namespace lightbatch::rays {

constexpr std::size_t kWidth = 8;

/// Reference to a child: its place in the casting tree in units of 16 bytes, and for a leaf of 1..8
/// triangles a flag and their count, for a grid another flag.
struct Child {
  static constexpr std::uint32_t kLeafFlag = 0x80000000u;
  static constexpr std::uint32_t kGridFlag = 0x40000000u;
  static constexpr std::uint32_t kMaxPlace = 1u << 28;
  static constexpr std::size_t kUnit = 16;

  static std::uint32_t leaf(std::size_t offset, std::uint32_t count) {
    return kLeafFlag | ((count - 1) << 28) | static_cast<std::uint32_t>(offset / kUnit);
  }
  static std::uint32_t grid(std::size_t offset) {
    return kGridFlag | static_cast<std::uint32_t>(offset / kUnit);
  }
  static bool is_leaf(std::uint32_t word) { return (word & kLeafFlag) != 0; }
  static bool is_grid(std::uint32_t word) { return (word & (kLeafFlag | kGridFlag)) == kGridFlag; }
  static std::uint32_t count(std::uint32_t word) { return ((word >> 28) & 7u) + 1; }
  /// In bytes, of either.
  static std::size_t offset(std::uint32_t word) {
    return kUnit * std::size_t{word & (kMaxPlace - 1)};
  }
};

/// Eight child boxes side by side. Unused places hold empty boxes, which no ray meets.
struct alignas(64) WideNode {
  float lower[3][kWidth];
  float upper[3][kWidth];
  std::uint32_t child[kWidth];
};

/// A leaf as stored: one float (`size`), count ids, 9 * count coordinates. Component j of triangle
/// i is coordinate j * count + i (corner j / 3, axis j % 3), so vector loads need no padding inside
/// a leaf; leaves begin at multiples of four.
struct Leaf {
  const float* data;
  std::uint32_t count;

  /// Sum of the extents of the box of the triangles, rounded up.
  float size() const { return data[0]; }
  std::uint32_t id(std::size_t i) const { return std::bit_cast<std::uint32_t>(data[1 + i]); }
  const float* corners() const { return data + 1 + count; }
};

/// The casting tree: the binary hierarchy with levels taken out. Every node is followed by the
/// leaves below it and then by its subtrees, so that what a ray needs next is near by. The root is
/// always a node and comes first.
struct WideTree {
  static constexpr std::uint32_t kFilteredFlag = 0x80000000u;  // in ids: asks the filter

  bool empty = true;
  alignas(16) float reach[4] = {};         // largest |coordinate| of the boxes on each axis
  hierarchy::LargeVector<std::byte> data;  // and padding, so that vector loads stay inside
  std::vector<GridNode> grids;
  GridNode refused;  // see Caster::refused_grid

  const std::byte* at(std::uint32_t word) const { return data.data() + Child::offset(word); }
  const WideNode& node(std::uint32_t word) const {
    return *reinterpret_cast<const WideNode*>(at(word));
  }
  const Grid& grid(std::uint32_t word) const { return *reinterpret_cast<const Grid*>(at(word)); }
  Leaf leaf(std::uint32_t word) const {
    return {reinterpret_cast<const float*>(at(word)), Child::count(word)};
  }
  std::size_t memory_bytes() const { return data.capacity(); }
};

WideTree collapse(const hierarchy::Hierarchy& tree, std::span<const Vec3f> positions,
                  std::span<const std::array<std::uint32_t, 3>> triangles,
                  std::span<const Surface> surfaces, Grids grids = Grids::kWhereCheaper);

}  // namespace lightbatch::rays
