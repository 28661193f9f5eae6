#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace lightbatch::batches {

/// A binary tree in depth-first order: the left child of i is i + 1; right[i] is the right child,
/// or 0 at a leaf. Node 0 is the root.
struct CutTree {
  std::vector<std::uint32_t> right;
  std::uint32_t size() const { return static_cast<std::uint32_t>(right.size()); }
  bool is_leaf(std::uint32_t i) const { return right[i] == 0; }
};

/// A set of nodes that covers every leaf once, ascending, with the sum of their costs.
struct Cut {
  std::vector<std::uint32_t> nodes;
  double cost = 0;     // without the penalty
  double penalty = 0;  // per node, that this cut is optimal for
};

/// Over all cuts, the one of least sum of (cost[i] + penalty); of equals, the one with fewer nodes.
/// Dynamic programming from the leaves, O(n).
Cut best_cut(const CutTree& tree, std::span<const double> cost, double penalty);

/// The cheapest cut of at most `limit` nodes among those optimal for some penalty (the lower convex
/// hull of cost against count): bisection on the penalty. limit 0: no limit.
Cut best_cut_within(const CutTree& tree, std::span<const double> cost, std::uint32_t limit);

}  // namespace lightbatch::batches
