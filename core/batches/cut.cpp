// The optimal cut of a tree by dynamic programming: of all ways to stop on the way down, bottom-up
// minimisation keeps the better of "stop here" and "both children's best" (pruning by cost
// complexity: Breiman, Friedman, Olshen, Stone: Classification and Regression Trees, 1984, whose
// penalty per leaf is our bound on the number of batches).
#include "core/batches/cut.h"

#include <algorithm>

#include "core/base/check.h"

namespace lightbatch::batches {

Cut best_cut(const CutTree& tree, std::span<const double> cost, double penalty) {
  LB_CHECK(cost.size() == tree.right.size(), "one cost per node");
  Cut cut;
  cut.penalty = penalty;
  const std::uint32_t n = tree.size();
  if (n == 0) return cut;
  std::vector<double> best(n);
  std::vector<bool> stop(n);
  for (std::uint32_t i = n; i-- > 0;) {
    best[i] = cost[i] + penalty;
    stop[i] = true;
    if (tree.is_leaf(i)) continue;
    const double below = best[i + 1] + best[tree.right[i]];
    if (below < best[i]) {
      best[i] = below;
      stop[i] = false;
    }
  }
  std::vector<std::uint32_t> stack{0};
  while (!stack.empty()) {
    const std::uint32_t i = stack.back();
    stack.pop_back();
    if (stop[i]) {
      cut.nodes.push_back(i);
      cut.cost += cost[i];
    } else {
      stack.push_back(tree.right[i]);
      stack.push_back(i + 1);
    }
  }
  return cut;
}

Cut best_cut_within(const CutTree& tree, std::span<const double> cost, std::uint32_t limit) {
  Cut cut = best_cut(tree, cost, 0);
  if (limit == 0 || cut.nodes.size() <= limit) return cut;
  double low = 0;
  double high = std::max(1e-9, cut.cost);
  Cut within = best_cut(tree, cost, high);
  while (within.nodes.size() > limit) {
    // Stopping at the root is optimal for a penalty above its cost, so this ends.
    low = high;
    high *= 4;
    within = best_cut(tree, cost, high);
  }
  for (int step = 0; step < 60 && within.nodes.size() != limit; ++step) {
    const double middle = 0.5 * (low + high);
    if (!(middle > low && middle < high)) break;
    Cut trial = best_cut(tree, cost, middle);
    if (trial.nodes.size() > limit) {
      low = middle;
    } else {
      high = middle;
      within = std::move(trial);
    }
  }
  return within;
}

}  // namespace lightbatch::batches
