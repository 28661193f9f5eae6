#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/hierarchy/tree_node.h"
#include "core/math/aabb.h"

namespace lightbatch::hierarchy {

/// The nodes of a Hierarchy by the same ids in about half the memory, boxes exact; reading one
/// takes several times as long. A leaf keeps its box. Each plane of another box is one of a leaf
/// below: smaller nodes say of which, counted from their first leaf, in a byte; the few larger ones
/// keep their boxes. Leaves before a node are counted by blocks of 64 nodes and a word of bits each
/// (G. Jacobson: Space-efficient Static Trees and Graphs, FOCS 1989).
class CompactNodes {
 public:
  CompactNodes() = default;
  explicit CompactNodes(std::span<const TreeNode> nodes);

  std::size_t node_count() const { return boxes_.empty() ? 0 : 2 * boxes_.size() - 1; }
  bool is_leaf(std::uint32_t i) const { return (blocks_[i / 64].leaves >> (i % 64) & 1u) != 0; }
  std::uint32_t first(std::uint32_t i) const {
    const Block& block = blocks_[i / 64];
    const std::uint64_t earlier = block.leaves & ((std::uint64_t{1} << (i % 64)) - 1);
    return block.before + static_cast<std::uint32_t>(std::popcount(earlier));
  }
  std::uint32_t count(std::uint32_t i) const {
    if (is_leaf(i)) return 1;
    const Inner& node = inner_[i - first(i)];
    return node.is_large() ? large_[node.large()].count : node.count();
  }
  Aabb box(std::uint32_t i) const;
  std::size_t memory_bytes() const;

 private:
  struct Block {
    std::uint64_t leaves = 0;  // bit k: node 64 b + k is one
    std::uint32_t before = 0;  // leaves in earlier blocks
  };
  /// Of 2 to 256 primitives: for each plane (three lower, three upper) the leaf, and the count
  /// less 1. Others: 0 for a count, and the place in large_.
  struct Inner {
    std::uint8_t leaf[6];
    std::uint8_t last;

    bool is_large() const { return last == 0; }
    std::uint32_t count() const { return last + 1u; }
    std::uint32_t large() const {
      return leaf[0] | std::uint32_t{leaf[1]} << 8 | std::uint32_t{leaf[2]} << 16 |
             std::uint32_t{leaf[3]} << 24;
    }
  };
  struct Large {
    Aabb box;
    std::uint32_t count;
  };
  static constexpr std::uint32_t kMostInBytes = 256;

  Inner small_node(std::span<const TreeNode> nodes, std::uint32_t i) const;

  std::vector<Block> blocks_;
  LargeVector<Aabb> boxes_;   // of leaves, in leaf order
  LargeVector<Inner> inner_;  // in the order of their ids
  std::vector<Large> large_;
};

}  // namespace lightbatch::hierarchy
