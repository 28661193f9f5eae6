#include "core/rays/compare.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/hierarchy/split_rule.h"
#include "core/hierarchy/statistics.h"
#include "tests/unit/hierarchy/box_sets.h"
#include "tests/unit/rays/oracle.h"

namespace lightbatch::rays {
namespace {

using hierarchy::Hierarchy;
using hierarchy::Method;

TEST(Comparators, AllKeepThePromisesOfTheHierarchy) {
  auto sets = hierarchy::testing::hostile_sets(1500);
  sets.push_back({"random", hierarchy::testing::random_boxes(1000, 0.1f, 2)});
  sets.push_back({"one", {Aabb{{0, 0, 0}, {1, 1, 1}}}});
  for (const auto& set : sets) {
    std::vector<std::uint32_t> objects(set.boxes.size());
    for (std::size_t i = 0; i < objects.size(); ++i) {
      objects[i] = static_cast<std::uint32_t>(i / 37);
    }
    for (const Method method : hierarchy::kMethods) {
      SCOPED_TRACE(set.name + ", " + hierarchy::method_name(method));
      const auto tree = hierarchy::build_with(method, set.boxes, objects);
      if (!tree) {
        EXPECT_EQ(method, Method::kInsertion);
        continue;
      }
      ASSERT_EQ(tree->primitive_count(), set.boxes.size());
      EXPECT_LE(measure(*tree).depth, hierarchy::kMaxDepth);
      std::size_t wrong = 0;
      std::vector<int> seen(set.boxes.size(), 0);
      for (Hierarchy::NodeId i = 0; i < tree->node_count(); ++i) {
        if (tree->is_leaf(i)) {
          ++seen[tree->primitive(tree->first(i))];
          wrong += !(tree->box(i) == set.boxes[tree->primitive(tree->first(i))]);
          continue;
        }
        Aabb both = tree->box(tree->left(i));
        both.add(tree->box(tree->right(i)));
        wrong += !(both == tree->box(i));
        wrong += tree->count(i) != tree->count(tree->left(i)) + tree->count(tree->right(i));
      }
      EXPECT_EQ(wrong, 0u);
      EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), std::ssize(seen));
    }
  }
}

TEST(Comparators, TheModelledTreeKeepsObjectsTogether) {
  // Objects of 2, 3 and 5 boxes: every object is one node.
  const auto boxes = hierarchy::testing::random_boxes(10, 0.1f, 1);
  const std::vector<std::uint32_t> objects{4, 4, 1, 1, 1, 9, 9, 9, 9, 9};
  const auto tree = hierarchy::build_with(Method::kAsModelled, boxes, objects);
  ASSERT_TRUE(tree.has_value());
  int found = 0;
  for (Hierarchy::NodeId i = 0; i < tree->node_count(); ++i) {
    found += (tree->first(i) == 0 && tree->count(i) == 2) ||
             (tree->first(i) == 2 && tree->count(i) == 3) ||
             (tree->first(i) == 5 && tree->count(i) == 5);
  }
  EXPECT_EQ(found, 3);
}

TEST(Compare, OrdersTheWaysAsKnown) {
  testing::Mesh mesh;
  Random random(2);
  for (int i = 0; i < 3000; ++i) {
    const Vec3f at = testing::random_point(random);
    mesh.add(at, at + testing::random_direction(random) * 0.03f,
             at + testing::random_direction(random) * 0.03f);
  }
  const auto rows = compare(mesh.boxes(), mesh.positions, mesh.triangles, {},
                            {.rays = 500, .overlap_samples = 500, .seed = 1});
  ASSERT_EQ(rows.size(), std::size(hierarchy::kMethods));
  const auto cost = [&](Method method) {
    return std::find_if(rows.begin(), rows.end(),
                        [&](const ComparisonRow& row) { return row.method == method; })
        ->sah_cost;
  };
  EXPECT_LE(cost(Method::kSweepReinsertion), cost(Method::kSweep));
  EXPECT_LT(cost(Method::kSweep), cost(Method::kMedianCut));
  EXPECT_LT(cost(Method::kBinned), cost(Method::kMedianCut));
  EXPECT_LT(cost(Method::kMorton), cost(Method::kAsModelled));
  EXPECT_LT(cost(Method::kInsertion), cost(Method::kAsModelled));
  for (const ComparisonRow& row : rows) {
    EXPECT_GT(row.rays_per_second, 0) << row.name;
    EXPECT_GT(row.grid_rays_per_second, 0) << row.name;
  }
}

}  // namespace
}  // namespace lightbatch::rays
