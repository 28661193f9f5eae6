#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "core/hierarchy/builder.h"
#include "core/hierarchy/split_rule.h"

namespace lightbatch::hierarchy {

/// The top of a binary tree, whose subtrees can be moved: nodes of at least some area, and below
/// them whole subtrees of the tree that it was made from. The two children of a node lie side by
/// side in a pair of slots (2k, 2k + 1), so the sibling of slot i is i ^ 1; the root is slot 0.
class LinkedTree {
 public:
  using Slot = std::uint32_t;
  using Planes = float __attribute__((vector_size(16)));

  /// Upper planes are negated: union is the minimum. In place of a child pair leaves hold
  /// kLeaf | the node of the given tree whose subtree they stand for.
  struct alignas(32) Node {
    float lower[3];
    std::uint32_t link;
    float negated_upper[3];
    std::uint32_t count;
  };
  static constexpr std::uint32_t kLeaf = 0x80000000u;

  struct Box {
    Planes lower, negated_upper;
    void add(const Box& b) {
      lower = lower < b.lower ? lower : b.lower;
      negated_upper = negated_upper < b.negated_upper ? negated_upper : b.negated_upper;
    }
    /// Negated.
    Planes extent() const { return lower + negated_upper; }
    /// Half the surface area.
    float area() const {
      const Planes e = extent();
      return e[0] * e[1] + e[1] * e[2] + e[2] * e[0];
    }
  };

  /// Half the surface areas of four boxes of these extents.
  static Planes areas_of(Planes a, Planes b, Planes c, Planes d) {
    const Planes ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5);  // ax bx ay by
    const Planes cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5);
    const Planes ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
    const Planes cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    const Planes x = __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5);
    const Planes y = __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7);
    const Planes z = __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5);
    return x * y + y * z + z * x;
  }

  /// Nodes of `tree` with boxes smaller than `least_area` (half the surface), but not the root,
  /// become leaves. The tree is kept by reference.
  LinkedTree(const TreeArrays& tree, float least_area);
  /// Puts the tree in the place of `tree`, the one that it was made from: depth-first, subtrees
  /// below leaves included. False, and nothing done, if it is deeper than kMaxDepth; else this is
  /// not to be used any more.
  bool write(TreeArrays& tree) const;

  std::uint32_t slot_count() const { return static_cast<std::uint32_t>(nodes_.size()); }
  bool is_leaf(Slot i) const { return (nodes_[i].link & kLeaf) != 0; }
  const Node* node(Slot i) const { return &nodes_[i]; }
  Slot child(Slot i) const { return nodes_[i].link; }
  Slot parent(Slot i) const { return parents_[i / 2]; }
  std::uint32_t count(Slot i) const { return nodes_[i].count; }
  /// Of a subtree of at most kMergedLeaf primitives: the sum of half areas of its nodes, those of a
  /// merged leaf once for each primitive, merged wherever that lowers it.
  float merged_cost(Slot i) const { return merged_costs_[i]; }
  /// By how much a node of half area `area` over these two children costs less than that and they,
  /// because it may be a merged leaf.
  float saved_by_merging(Slot a, Slot b, float area) const {
    const std::uint32_t n = nodes_[a].count + nodes_[b].count;
    if (n > kMergedLeaf) return 0;
    const float apart = area + merged_costs_[a] + merged_costs_[b];
    return std::max(0.0f, apart - area * static_cast<float>(n));
  }
  Box box(Slot i) const {
    Box b;
    std::memcpy(&b.lower, nodes_[i].lower, sizeof b.lower);
    std::memcpy(&b.negated_upper, nodes_[i].negated_upper, sizeof b.negated_upper);
    return b;
  }

  /// Sum of the half areas of the nodes and merged leaves of the top: less after than before moves
  /// by as much as the whole tree costs less.
  double cost() const;

  /// Takes `from` out (its sibling takes the parent's slot) and puts it beside `to` (whose slot
  /// becomes the parent of both). `to` must be neither its sibling nor its parent. Boxes and counts
  /// are brought up to date. Does nothing if `to` lies below `from` or if the top would become
  /// deeper than kMaxDepth.
  void move(Slot from, Slot to);

 private:
  void copy_node(Slot to, Slot from);
  std::uint8_t height_of_pair(Slot pair) const;
  float merged_cost_below(std::uint32_t node) const;
  void refit_merged_cost(Slot i);
  void refit_to_root(Slot i);
  struct Part;

  const TreeArrays& tree_;
  std::vector<Node> nodes_;
  std::vector<Slot> parents_;  // of each pair
  std::vector<float> merged_costs_;
  std::vector<std::uint8_t> heights_;  // levels of the top below each slot
};

}  // namespace lightbatch::hierarchy
