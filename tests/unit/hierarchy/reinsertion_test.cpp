#include "core/hierarchy/reinsertion.h"

#include <gtest/gtest.h>

#include <cstring>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/hierarchy/linked_tree.h"
#include "core/hierarchy/statistics.h"
#include "core/hierarchy/sweep.h"
#include "tests/unit/hierarchy/box_sets.h"

namespace lightbatch::hierarchy {
namespace {

TEST(LinkedTree, ThereAndBackIsTheSameTree) {
  for (std::size_t n = 1; n < 60; ++n) {
    const TreeArrays tree = sweep(testing::random_boxes(n, 0.1f, n));
    for (const float least_area : {0.0f, 0.1f, 100.0f}) {
      TreeArrays again = tree;
      ASSERT_TRUE(LinkedTree(again, least_area).write(again));
      ASSERT_EQ(tree.nodes.size(), again.nodes.size());
      EXPECT_EQ(
          std::memcmp(tree.nodes.data(), again.nodes.data(), tree.nodes.size() * sizeof(TreeNode)),
          0);
      EXPECT_EQ(tree.primitives, again.primitives);
    }
  }
}

/// Few subtrees change their place, or many.
TEST(LinkedTree, WritesWhatWasMoved) {
  constexpr float kLeastArea = 0.1f;  // subtrees below remain
  const TreeArrays tree = sweep(testing::random_boxes(300, 0.1f, 3));
  Random random(5);
  std::size_t stayed[2] = {0, 0};  // trees in which at most half, or more, of the nodes did
  for (int trial = 0; trial < 300; ++trial) {
    TreeArrays written = tree;
    LinkedTree linked(written, kLeastArea);
    const auto slot = [&] {
      return static_cast<LinkedTree::Slot>(2 + random.below(linked.slot_count() - 2));
    };
    const LinkedTree::Slot from = slot(), to = slot();
    if ((from ^ to) <= 1 || linked.parent(from) == to) continue;
    linked.move(from, to);
    ASSERT_TRUE(linked.write(written));
    std::uint32_t node = 0, leaf = 0;
    std::size_t same = 0;
    const auto check = [&](const auto& self, LinkedTree::Slot i) -> void {
      const std::uint32_t n = linked.count(i);
      const TreeNode& root = written.nodes[node];
      ASSERT_EQ(root.count, n);
      ASSERT_EQ(root.first, leaf);
      ASSERT_EQ(root.lower[0], linked.node(i)->lower[0]);
      ASSERT_EQ(root.upper[2], -linked.node(i)->negated_upper[2]);
      if (!linked.is_leaf(i)) {
        ++node;
        self(self, linked.child(i));
        self(self, linked.child(i) + 1);
        return;
      }
      const std::uint32_t old = linked.node(i)->link & ~LinkedTree::kLeaf;
      if (old == node) same += 2 * n - 1;
      for (std::uint32_t k = 0; k < 2 * n - 1; ++k) {
        TreeNode expected = tree.nodes[old + k];
        expected.first += leaf - tree.nodes[old].first;
        ASSERT_EQ(std::memcmp(&written.nodes[node + k], &expected, sizeof expected), 0);
      }
      for (std::uint32_t k = 0; k < n; ++k) {
        ASSERT_EQ(written.primitives[leaf + k], tree.primitives[tree.nodes[old].first + k]);
      }
      node += 2 * n - 1;
      leaf += n;
    };
    check(check, 0);
    ASSERT_EQ(node, tree.nodes.size());
    ++stayed[2 * same > tree.nodes.size() ? 1 : 0];
  }
  EXPECT_GT(stayed[0], 20u);
  EXPECT_GT(stayed[1], 20u);
}

TEST(LinkedTree, RefusesToMoveANodeBelowItself) {
  const TreeArrays tree = sweep(testing::random_boxes(50, 0.1f, 1));
  TreeArrays same = tree;
  LinkedTree linked(same, 0);
  const LinkedTree::Slot from = linked.child(0);
  ASSERT_FALSE(linked.is_leaf(from));
  linked.move(from, linked.child(from));
  ASSERT_TRUE(linked.write(same));
  EXPECT_EQ(tree.primitives, same.primitives);
}

TEST(Reinsertion, NeverRaisesTheCostAndHelpsWhereTheSweepIsGreedy) {
  double before = 0, after = 0;
  for (const testing::BoxSet& set : testing::hostile_sets(5000)) {
    const double swept = measure(build(set.boxes, {.reinsertion = false})).sah_cost_merged;
    const double better = measure(build(set.boxes)).sah_cost_merged;
    // Gains are computed in float; the sums compared here are double.
    EXPECT_LE(better, swept * 1.0001) << set.name;
  }
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    std::vector<Aabb> boxes = testing::random_boxes(5000, 0.02f, seed);
    for (std::size_t i = 0; i < 50; ++i) boxes[i].upper = boxes[i].lower + Vec3f{1, 0.01f, 1};
    before += measure(build(boxes, {.reinsertion = false})).sah_cost_merged;
    after += measure(build(boxes)).sah_cost_merged;
  }
  // Large plates among small boxes: the case the second stage is for.
  EXPECT_LT(after, 0.98 * before);
}

TEST(Reinsertion, LargeBoxesFindOneAnother) {
  // Apart from one another each would be a level of its own.
  constexpr std::size_t kLarge = 64;
  std::vector<Aabb> boxes = testing::random_boxes(5000, 0.02f, 7);
  for (std::size_t i = 0; i < kLarge; ++i) boxes[i * 70] = {{0, 0, 0}, {1, 1, 1}};
  const Hierarchy tree = build(boxes);
  EXPECT_LT(measure(tree).depth, static_cast<int>(kLarge) / 2);
  // At worst a node as large as all for each box: 2 * kLarge.
  const double others = measure(build(testing::random_boxes(5000, 0.02f, 7))).sah_cost_merged;
  EXPECT_LT(measure(tree).sah_cost_merged, others + 1.3 * kLarge);
}

}  // namespace
}  // namespace lightbatch::hierarchy
