#pragma once

#include <cstdint>
#include <vector>

#include "core/batches/assignment.h"
#include "core/batches/cut.h"
#include "core/hierarchy/hierarchy.h"

namespace lightbatch::batches {

/// The cuts of merged triangles: one through the hierarchy for each key, so that a material with
/// few triangles is drawn by one call while one with many is split finely. What is drawn at the
/// same node is one batch.
class KeyCuts {
 public:
  /// Goes down to small nodes only; nodes with nothing to merge on one side are passed over.
  KeyCuts(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
          const std::vector<bool>& merged_triangle, const KeyMap& keys, std::uint32_t max_vertices,
          const ViewDistribution& views);

  struct Solution {
    std::vector<std::uint32_t> at;  // per entry: the node where it is drawn
    std::uint32_t batches = 0;      // nodes where something is drawn
    Frame frame;
  };
  /// The cheapest cuts, by dynamic programming.
  Solution solve(const Prices& prices) const;
  /// The same with at most `limit` batches (0: any number). Where that binds, all keys share one
  /// cut, the cheapest of so many nodes.
  Solution solve_within(const Prices& prices, std::uint32_t limit) const;

  /// The node (of tree()) that draws each merged triangle; kNone for others.
  std::vector<std::uint32_t> nodes_of_triangles(const Solution& solution,
                                                const hierarchy::Hierarchy& tree,
                                                const KeyMap& keys,
                                                const std::vector<bool>& merged_triangle) const;

  const CutTree& tree() const { return tree_; }
  bool is_empty() const { return node_.empty(); }

 private:
  /// A key at a node.
  struct Entry {
    std::uint32_t key = 0;
    Frame frame;
  };
  void make_tree(const hierarchy::Hierarchy& tree, const std::vector<bool>& merged_triangle);
  /// Draws every key where it first meets a stop on the way down.
  Solution place(const std::vector<bool>& stop) const;
  /// Position of a key among the entries of a node, or kNone.
  std::uint32_t entry(std::uint32_t node, std::uint32_t key) const;

  CutTree tree_;
  std::vector<hierarchy::Hierarchy::NodeId> node_;  // of the hierarchy
  std::vector<std::uint32_t> first_;                // entries of node i: first_[i] to first_[i + 1]
  std::vector<Entry> entries_;                      // by key within a node
};

}  // namespace lightbatch::batches
