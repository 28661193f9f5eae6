#include "core/batches/cut.h"

#include <gtest/gtest.h>

#include <map>

#include "core/base/random.h"

namespace lightbatch::batches {
namespace {

/// A random tree of `leaves` leaves in depth-first order.
void grow(CutTree& tree, std::uint32_t leaves, Random& random) {
  const std::uint32_t id = tree.size();
  tree.right.push_back(0);
  if (leaves == 1) return;
  const auto left = static_cast<std::uint32_t>(1 + random.below(leaves - 1));
  grow(tree, left, random);
  tree.right[id] = tree.size();
  grow(tree, leaves - left, random);
}

/// Least cost of all cuts of a node by their number of nodes, by trying every one.
std::map<std::uint32_t, double> all_cuts(const CutTree& tree, const std::vector<double>& cost,
                                         std::uint32_t node) {
  std::map<std::uint32_t, double> best{{1, cost[node]}};
  if (tree.is_leaf(node)) return best;
  const auto left = all_cuts(tree, cost, node + 1);
  const auto right = all_cuts(tree, cost, tree.right[node]);
  for (const auto& [a, cost_a] : left)
    for (const auto& [b, cost_b] : right) {
      const auto it = best.try_emplace(a + b, cost_a + cost_b).first;
      it->second = std::min(it->second, cost_a + cost_b);
    }
  return best;
}

class CutOfRandomTrees : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  void SetUp() override {
    Random random(item_seed(7, GetParam()));
    grow(tree_, static_cast<std::uint32_t>(1 + random.below(14)), random);
    for (std::uint32_t i = 0; i < tree_.size(); ++i) cost_.push_back(random.next_double() * 10);
  }
  CutTree tree_;
  std::vector<double> cost_;
};

TEST_P(CutOfRandomTrees, EqualsTryingAll) {
  for (const double penalty : {0.0, 0.5, 3.0}) {
    double least = 1e300;
    for (const auto& [count, cost] : all_cuts(tree_, cost_, 0))
      least = std::min(least, cost + penalty * count);
    const Cut cut = best_cut(tree_, cost_, penalty);
    // The same sums in another order: a few units in the last place.
    EXPECT_NEAR(cut.cost + penalty * static_cast<double>(cut.nodes.size()), least, 1e-12 * least);
  }
}

TEST_P(CutOfRandomTrees, CoversEveryLeafOnce) {
  const Cut cut = best_cut(tree_, cost_, 0.1);
  std::vector<int> covered(tree_.size(), 0);
  for (const std::uint32_t node : cut.nodes) {
    std::vector<std::uint32_t> stack{node};
    while (!stack.empty()) {
      const std::uint32_t i = stack.back();
      stack.pop_back();
      if (tree_.is_leaf(i)) {
        ++covered[i];
      } else {
        stack.push_back(i + 1);
        stack.push_back(tree_.right[i]);
      }
    }
  }
  for (std::uint32_t i = 0; i < tree_.size(); ++i) EXPECT_EQ(covered[i], tree_.is_leaf(i) ? 1 : 0);
}

TEST_P(CutOfRandomTrees, LimitIsKeptAndOnTheHull) {
  const auto all = all_cuts(tree_, cost_, 0);
  for (std::uint32_t limit = 1; limit <= 8; ++limit) {
    const Cut cut = best_cut_within(tree_, cost_, limit);
    const auto count = static_cast<std::uint32_t>(cut.nodes.size());
    EXPECT_LE(count, limit);
    // No cut is better for the penalty that it was found with.
    for (const auto& [n, cost] : all)
      EXPECT_LE(cut.cost + cut.penalty * count, cost + cut.penalty * n + 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, CutOfRandomTrees, ::testing::Range<std::uint64_t>(0, 60));

TEST(Cut, EmptyTree) {
  EXPECT_TRUE(best_cut({}, {}, 0).nodes.empty());
  EXPECT_TRUE(best_cut_within({}, {}, 3).nodes.empty());
}

TEST(Cut, EqualCostsGiveFewerNodes) {
  const CutTree tree{{2, 0, 0}};
  const std::vector<double> cost{2, 1, 1};
  EXPECT_EQ(best_cut(tree, cost, 0).nodes.size(), 1u);
}

}  // namespace
}  // namespace lightbatch::batches
