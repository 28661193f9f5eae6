#pragma once

#include <cstdint>
#include <span>

#include "core/hierarchy/compact_nodes.h"
#include "core/hierarchy/large_vector.h"
#include "core/hierarchy/tree_node.h"
#include "core/math/aabb.h"

namespace lightbatch::hierarchy {

/// The one tree of the product: binary, tight axis-aligned boxes, single primitives at the leaves,
/// no primitive twice. Depth-first order: the root is node 0, the left child of i is i + 1, the
/// right child is i + 2 * count(i + 1); a node over n primitives takes 2n - 1 places. So the tree
/// of a set of boxes does not depend on threads or timing. Safe to read from any thread.
///
/// A node covers the leaves [first(i), first(i) + count(i)) of leaf order; primitive(k) is the
/// primitive of leaf k. Clusters of radiosity, culling and batches are nodes of this tree.
class Hierarchy {
 public:
  using NodeId = std::uint32_t;

  bool is_empty() const { return primitives_.empty(); }
  std::uint32_t node_count() const {
    return static_cast<std::uint32_t>(is_compact() ? compact_.node_count() : nodes_.size());
  }
  std::uint32_t primitive_count() const { return static_cast<std::uint32_t>(primitives_.size()); }

  bool is_leaf(NodeId i) const { return is_compact() ? compact_.is_leaf(i) : nodes_[i].count == 1; }
  NodeId left(NodeId i) const { return i + 1; }
  NodeId right(NodeId i) const { return i + 2 * count(i + 1); }
  Aabb box(NodeId i) const {
    if (is_compact()) return compact_.box(i);
    const TreeNode& n = nodes_[i];
    return {{n.lower[0], n.lower[1], n.lower[2]}, {n.upper[0], n.upper[1], n.upper[2]}};
  }
  std::uint32_t first(NodeId i) const { return is_compact() ? compact_.first(i) : nodes_[i].first; }
  std::uint32_t count(NodeId i) const { return is_compact() ? compact_.count(i) : nodes_[i].count; }
  std::uint32_t primitive(std::uint32_t leaf_order) const { return primitives_[leaf_order]; }
  std::span<const std::uint32_t> primitives(NodeId i) const {
    return std::span(primitives_).subspan(first(i), count(i));
  }
  /// Takes about half the memory from then on; nodes stay what they are, but reading one takes
  /// several times as long. For trees that are kept, not searched.
  void compact();
  std::size_t memory_bytes() const;

 private:
  bool is_compact() const { return nodes_.empty(); }

  friend class HierarchyBuilder;
  TreeNodes nodes_;  // or
  CompactNodes compact_;
  LargeVector<std::uint32_t> primitives_;
};

struct BuildOptions {
  bool reinsertion = true;  // second stage (Bittner 2013; Meister and Bittner 2018)
};

/// Builds the tree over boxes (finite, lower <= upper; at most 2^30). Mueller, Schaefer, Fellner
/// 1999: every split position on three axes of lists sorted once, the cheapest taken.
/// O(n log n); depth is bounded on any input; same tree on any number of threads.
Hierarchy build(std::span<const Aabb> boxes, const BuildOptions& options = {});

}  // namespace lightbatch::hierarchy
