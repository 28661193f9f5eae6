#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "core/hierarchy/level_boxes.h"
#include "core/hierarchy/statistics.h"
#include "tests/unit/hierarchy/box_sets.h"

namespace lightbatch::hierarchy {
namespace {

TEST(Statistics, ClosedFormForTwoUnitCubes) {
  // Two unit cubes with a gap of 2 between them: root 4 x 1 x 1, area 18; leaves 6 each.
  const std::vector<Aabb> boxes{{{0, 0, 0}, {1, 1, 1}}, {{3, 0, 0}, {4, 1, 1}}};
  const Statistics s = measure(build(boxes));
  EXPECT_EQ(s.depth, 1);
  EXPECT_DOUBLE_EQ(s.mean_leaf_depth, 1);
  EXPECT_DOUBLE_EQ(s.sah_cost, 1 + 12.0 / 18);
  EXPECT_DOUBLE_EQ(s.sah_cost_merged, 1 + 12.0 / 18);
  EXPECT_DOUBLE_EQ(s.void_area, 6.0 / 18);
  ASSERT_EQ(s.levels.size(), 2u);
  EXPECT_EQ(s.levels[0].inner, 1u);
  EXPECT_EQ(s.levels[1].leaves, 2u);
}

TEST(Statistics, MergingIdenticalBoxesPays) {
  // Eight equal boxes: single leaves cost 8 + 7 inner; merged into one leaf 8.
  const std::vector<Aabb> boxes(8, Aabb{{0, 0, 0}, {1, 2, 3}});
  const Statistics s = measure(build(boxes));
  EXPECT_DOUBLE_EQ(s.sah_cost, 15);
  EXPECT_DOUBLE_EQ(s.sah_cost_merged, 8);
  EXPECT_DOUBLE_EQ(s.void_area, 0);
}

TEST(Statistics, NothingMeasuresAsZero) {
  EXPECT_EQ(measure(build({})).nodes, 0u);
  const std::vector<Aabb> points(5, Aabb{{1, 1, 1}, {1, 1, 1}});
  EXPECT_EQ(measure(build(points)).sah_cost, 0);
}

TEST(Statistics, OverlapOfDisjointAndOfStackedTriangles) {
  std::vector<Vec3f> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Aabb> boxes;
  const auto add = [&](float x) {
    const auto k = static_cast<std::uint32_t>(positions.size());
    positions.insert(positions.end(), {{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}});
    triangles.push_back({k, k + 1, k + 2});
    boxes.push_back({{x, 0, 0}, {x + 1, 1, 0}});
  };
  for (int i = 0; i < 8; ++i) add(static_cast<float>(3 * i));
  EXPECT_EQ(effective_partial_overlap(build(boxes), positions, triangles, 1000, 1), 0);
  positions.clear();
  triangles.clear();
  boxes.clear();
  for (int i = 0; i < 2; ++i) add(0);
  EXPECT_EQ(effective_partial_overlap(build(boxes), positions, triangles, 1000, 1), 1);
}

TEST(Levels, EveryLevelCoversEveryPrimitiveOnce) {
  const Hierarchy tree = build(testing::random_boxes(500, 0.1f, 4));
  for (int level = 0; level <= measure(tree).depth + 1; ++level) {
    std::uint32_t next = 0;
    for (const Hierarchy::NodeId node : level_nodes(tree, level)) {
      EXPECT_EQ(tree.first(node), next);
      next += tree.count(node);
    }
    EXPECT_EQ(next, 500u);
  }
  EXPECT_EQ(level_boxes(tree, 0).size(), 1u);
  EXPECT_EQ(level_boxes(tree, 1).size(), 2u);
  EXPECT_TRUE(level_boxes(Hierarchy(), 3).empty());
}

TEST(Levels, PictureShowsTheNearestBox) {
  // A small box far behind a large one is hidden; the picture is the same without it.
  const std::vector<Aabb> two{{{0, 0, 0}, {4, 4, 4}}, {{1, 1, 1}, {2, 2, 2}}};
  const image::Image8 a = level_picture(two, 64, 48);
  const image::Image8 b = level_picture(std::span(two).first(1), 64, 48);
  EXPECT_EQ(a.width, 64);
  EXPECT_EQ(a.height, 48);
  ASSERT_EQ(a.rgba.size(), 64u * 48u * 4u);
  EXPECT_EQ(a.rgba, b.rgba);
  const std::uint8_t* corner = a.pixel(0, 0);
  const std::uint8_t* middle = a.pixel(32, 24);
  EXPECT_EQ(corner[0], 255);
  EXPECT_LT(middle[0], 255);
}

TEST(Levels, DrawingsTakeAnything) {
  for (const auto& set : testing::hostile_sets(300)) {
    EXPECT_EQ(level_picture(set.boxes, 32, 32).rgba.size(), 32u * 32u * 4u) << set.name;
    const std::string svg = level_svg(set.boxes, 100, 100, 50);
    EXPECT_NE(svg.find("250 smaller boxes left out"), std::string::npos);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
  }
  EXPECT_EQ(level_picture({}, 0, -5).width, 16);
  EXPECT_NE(level_svg({}, 100, 100).find("</svg>"), std::string::npos);
}

}  // namespace
}  // namespace lightbatch::hierarchy
