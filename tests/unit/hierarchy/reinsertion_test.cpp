#include "core/hierarchy/reinsertion.h"

#include <gtest/gtest.h>

#include <cstring>

#include "core/base/parallel.h"
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
      const TreeArrays again = LinkedTree(tree, least_area).write();
      ASSERT_EQ(tree.nodes.size(), again.nodes.size());
      EXPECT_EQ(
          std::memcmp(tree.nodes.data(), again.nodes.data(), tree.nodes.size() * sizeof(TreeNode)),
          0);
      EXPECT_EQ(tree.primitives, again.primitives);
    }
  }
}

TEST(LinkedTree, RefusesToMoveANodeBelowItself) {
  const TreeArrays tree = sweep(testing::random_boxes(50, 0.1f, 1));
  LinkedTree linked(tree, 0);
  const LinkedTree::Slot from = linked.child(0);
  ASSERT_FALSE(linked.is_leaf(from));
  linked.move(from, linked.child(from));
  EXPECT_EQ(tree.primitives, linked.write().primitives);
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
