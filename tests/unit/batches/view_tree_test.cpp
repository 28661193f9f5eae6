#include "core/batches/view_tree.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/batches/scenes.h"

namespace lightbatch::batches {
namespace {

TEST(ViewTree, CoversEachClusterOnceUnderTightBoxes) {
  const auto scene = testing::grid_scene(8);
  const ViewDistribution views(Viewpoints(scene, {}));
  std::vector<Aabb> boxes;
  std::vector<double> triangles;
  for (const scene::Object& object : scene.objects) {
    Aabb box;
    for (std::uint32_t k = 0; k < object.triangle_count; ++k)
      for (const Vec3f& p : scene.corners(object.first_triangle + k)) box.add(p);
    boxes.push_back(box);
    triangles.push_back(object.triangle_count);
  }
  const ViewTree tree = split_by_views(boxes, triangles, views);
  ASSERT_EQ(tree.tree.size(), 2 * boxes.size() - 1);
  auto order = tree.order;
  std::sort(order.begin(), order.end());
  for (std::uint32_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], i);
  for (std::uint32_t i = 0; i < tree.tree.size(); ++i) {
    Aabb box;
    for (const std::uint32_t c : tree.clusters(i)) box.add(boxes[c]);
    EXPECT_EQ(box, tree.box[i]);
    if (tree.tree.is_leaf(i)) {
      EXPECT_EQ(tree.count[i], 1u);
      continue;
    }
    const std::uint32_t right = tree.tree.right[i];
    EXPECT_EQ(tree.first[i + 1], tree.first[i]);
    EXPECT_EQ(tree.first[right], tree.first[i] + tree.count[i + 1]);
    EXPECT_EQ(tree.count[i], tree.count[i + 1] + tree.count[right]);
  }
}

TEST(ViewTree, SplitsWhereViewsPart) {
  // Two heaps far apart, interleaved in the list.
  testing::SceneBuilder builder;
  std::vector<Aabb> boxes;
  for (int i = 0; i < 10; ++i) {
    const float x = (i % 2 == 0 ? 0.0f : 500.0f) + static_cast<float>(i);
    builder.add_box({x, 0, 0}, {x + 1, 1, 1});
    boxes.push_back({{x, 0, 0}, {x + 1, 1, 1}});
  }
  const auto scene = builder.take();
  const std::vector<double> triangles(boxes.size(), 12);
  const ViewTree tree = split_by_views(boxes, triangles, ViewDistribution(Viewpoints(scene, {})));
  ASSERT_EQ(tree.count[1], 5u);
  for (const std::uint32_t c : tree.clusters(1)) EXPECT_EQ(c % 2, tree.clusters(1)[0] % 2);
}

TEST(ViewTree, IdenticalBoxesAndNone) {
  const auto scene = testing::grid_scene(2);
  const ViewDistribution views(Viewpoints(scene, {}));
  EXPECT_EQ(split_by_views({}, {}, views).tree.size(), 0u);
  const std::vector<Aabb> boxes(100, scene.box);
  EXPECT_EQ(split_by_views(boxes, std::vector<double>(100, 1), views).tree.size(), 199u);
}

}  // namespace
}  // namespace lightbatch::batches
