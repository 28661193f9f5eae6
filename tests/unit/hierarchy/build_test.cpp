#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/parallel.h"
#include "core/hierarchy/hierarchy.h"
#include "core/hierarchy/split_rule.h"
#include "tests/unit/hierarchy/box_sets.h"

namespace lightbatch::hierarchy {
namespace {

using testing::BoxSet;

int depth_of(const Hierarchy& tree) {
  std::vector<int> depth(tree.node_count(), 0);
  int deepest = 0;
  for (Hierarchy::NodeId i = 0; i < tree.node_count(); ++i) {
    deepest = std::max(deepest, depth[i]);
    if (tree.is_leaf(i)) continue;
    depth[tree.left(i)] = depth[i] + 1;
    depth[tree.right(i)] = depth[i] + 1;
  }
  return deepest;
}

/// Every promise of the class that can be seen from outside.
void expect_valid(const Hierarchy& tree, std::span<const Aabb> boxes, const std::string& name) {
  SCOPED_TRACE(name);
  ASSERT_EQ(tree.primitive_count(), boxes.size());
  ASSERT_EQ(tree.node_count(), 2 * boxes.size() - 1);
  std::vector<int> seen(boxes.size(), 0);
  std::uint32_t leaves = 0;
  std::size_t wrong = 0;
  for (Hierarchy::NodeId i = 0; i < tree.node_count(); ++i) {
    wrong += tree.first(i) != leaves;
    if (tree.is_leaf(i)) {
      const std::uint32_t primitive = tree.primitive(tree.first(i));
      ++seen[primitive];
      ++leaves;
      wrong += tree.count(i) != 1 || !(tree.box(i) == boxes[primitive]);
    } else {
      Aabb both = tree.box(tree.left(i));
      both.add(tree.box(tree.right(i)));
      wrong += !(both == tree.box(i));
      wrong += tree.count(i) != tree.count(tree.left(i)) + tree.count(tree.right(i));
      wrong += tree.left(i) != i + 1 || tree.right(i) != i + 2 * tree.count(i + 1);
    }
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(boxes.size()));
  EXPECT_LE(depth_of(tree), kMaxDepth);
}

bool same_tree(const Hierarchy& a, const Hierarchy& b) {
  if (a.node_count() != b.node_count()) return false;
  for (Hierarchy::NodeId i = 0; i < a.node_count(); ++i) {
    if (a.count(i) != b.count(i) || a.first(i) != b.first(i) || !(a.box(i) == b.box(i))) {
      return false;
    }
  }
  for (std::uint32_t k = 0; k < a.primitive_count(); ++k) {
    if (a.primitive(k) != b.primitive(k)) return false;
  }
  return true;
}

TEST(Build, NothingAndOne) {
  EXPECT_TRUE(build({}).is_empty());
  const std::vector<Aabb> one{{{0, 0, 0}, {1, 1, 1}}};
  const Hierarchy tree = build(one);
  expect_valid(tree, one, "one");
  EXPECT_TRUE(tree.is_leaf(0));
}

TEST(Build, SmallSetsOfEverySize) {
  for (std::size_t n = 1; n <= 70; ++n) {
    const auto boxes = testing::random_boxes(n, 0.1f, n);
    expect_valid(build(boxes), boxes, std::to_string(n));
  }
}

TEST(Build, SplitsWhereTheGapIs) {
  // Two groups, 3 and 5, far apart on z: the root must separate them.
  std::vector<Aabb> boxes = testing::random_boxes(8, 0.1f, 3);
  for (std::size_t i = 0; i < 3; ++i) {
    boxes[i].lower.z += 100;
    boxes[i].upper.z += 100;
  }
  const Hierarchy tree = build(boxes, {.reinsertion = false});
  EXPECT_EQ(tree.count(tree.left(0)), 5u);
  EXPECT_LT(tree.box(tree.left(0)).upper.z, 50);
}

TEST(Build, HostileSetsFinishWithBoundedDepth) {
  for (const BoxSet& set : testing::hostile_sets(20000)) {
    expect_valid(build(set.boxes), set.boxes, set.name);
  }
}

TEST(Build, IdenticalBoxesGiveABalancedTree) {
  const std::vector<Aabb> boxes(1 << 14, Aabb{{0, 0, 0}, {1, 1, 1}});
  EXPECT_EQ(depth_of(build(boxes, {.reinsertion = false})), 14);
}

TEST(Build, SameTreeOnAnyNumberOfThreads) {
  const int before = thread_count();
  auto sets = testing::hostile_sets(30000);
  sets.push_back({"random", testing::random_boxes(100000, 0.02f, 1)});
  sets.push_back({"grid", testing::grid_boxes(40)});
  for (const BoxSet& set : sets) {
    set_thread_count(1);
    const Hierarchy one = build(set.boxes);
    for (const int threads : {2, 3}) {
      set_thread_count(threads);
      EXPECT_TRUE(same_tree(one, build(set.boxes))) << set.name << ", threads " << threads;
    }
  }
  set_thread_count(before);
}

TEST(Hierarchy, CompactReadsTheSame) {
  auto sets = testing::hostile_sets(3000);
  sets.push_back({"random", testing::random_boxes(20000, 0.1f, 4)});
  sets.push_back({"one", {Aabb{{0, 0, 0}, {1, 1, 1}}}});
  for (const BoxSet& set : sets) {
    const Hierarchy plain = build(set.boxes);
    Hierarchy tree = plain;
    tree.compact();
    expect_valid(tree, set.boxes, set.name);
    EXPECT_TRUE(same_tree(plain, tree)) << set.name;
    if (set.boxes.size() > 1000) {
      EXPECT_LE(tree.memory_bytes(), 40 * set.boxes.size()) << set.name;
    }
    tree.compact();
    EXPECT_TRUE(same_tree(plain, tree)) << set.name;
  }
  Hierarchy empty;
  empty.compact();
  EXPECT_TRUE(empty.is_empty());
  EXPECT_EQ(empty.node_count(), 0u);
}

}  // namespace
}  // namespace lightbatch::hierarchy
