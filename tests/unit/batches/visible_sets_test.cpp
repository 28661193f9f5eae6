#include "core/batches/visible_sets.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/parallel.h"
#include "tests/unit/batches/scenes.h"

namespace lightbatch::batches {
namespace {

using testing::hierarchy_of;
using testing::SceneBuilder;

/// Two rooms of 10 m side by side with a box in each and a wall between that leaves a gap (metres).
struct TwoRooms {
  scene::Scene scene;
  std::uint32_t left = 0, right = 0, wall = 0;  // objects
};

enum class Wall { kThick, kFacesRight, kFacesLeft };

TwoRooms two_rooms(float gap, scene::AlphaMode mode = scene::AlphaMode::kOpaque,
                   Wall wall = Wall::kThick, float at = 0) {
  SceneBuilder builder;
  const std::uint32_t material = builder.add_material(mode);
  builder.add_box({-10, -0.2f, 0}, {10, 0, 10});
  builder.add_box({-10, 3, 0}, {10, 3.2f, 10});
  for (const float x : {-10.2f, 10.0f}) builder.add_box({x, 0, 0}, {x + 0.2f, 3, 10});
  for (const float z : {-0.2f, 10.0f}) builder.add_box({-10, 0, z}, {10, 3, z + 0.2f});
  TwoRooms rooms;
  if (wall == Wall::kThick)
    rooms.wall = builder.add_box({at - 0.1f, 0, 0}, {at + 0.1f, 3, 10 - gap}, material);
  else
    rooms.wall =
        builder.add_wall({at, 0, 0}, {at, 3, 10 - gap}, wall == Wall::kFacesRight, material);
  rooms.left = builder.add_box({-7, 0, 4}, {-6, 1, 5}, builder.add_material());
  rooms.right = builder.add_box({6, 0, 4}, {7, 1, 5}, builder.add_material());
  rooms.scene = builder.take();
  return rooms;
}

BatchPlan plan_in(const scene::Scene& scene, const BatchOptions& options = {}) {
  Profile dear;
  dear.triangle = 10;  // small batches
  return *plan(scene, hierarchy_of(scene), Viewpoints(scene, dear), options);
}

/// The batches that draw an object.
std::vector<std::uint32_t> batches_of(const BatchPlan& plan, std::uint32_t object) {
  std::vector<std::uint32_t> result;
  for (std::uint32_t b = 0; b < plan.batches.size(); ++b)
    for (const Group& group : plan.batches[b].groups)
      for (const Piece& piece : group.pieces)
        if (piece.object == object && (result.empty() || result.back() != b)) result.push_back(b);
  return result;
}

/// Share of the cells with x above 1 that see a batch of the object.
double seen_from_the_right(const VisibleSets& sets, const BatchPlan& plan, std::uint32_t object) {
  int cells = 0, seeing = 0;
  const auto wanted = batches_of(plan, object);
  for (const ViewCell& cell : sets.cells) {
    if (cell.box.lower.x < 1 || cell.box.upper.x > 10 || cell.box.upper.y > 2.5f ||
        cell.box.upper.z > 10 || cell.box.lower.z < 0)
      continue;
    ++cells;
    seeing += std::any_of(wanted.begin(), wanted.end(), [&](std::uint32_t b) {
      return std::binary_search(cell.seen.begin(), cell.seen.end(), b);
    });
  }
  return cells == 0 ? -1 : static_cast<double>(seeing) / cells;
}

VisibleSets sets_of(const scene::Scene& scene, const BatchPlan& plan) {
  return *find_visible_sets(scene, hierarchy_of(scene), Viewpoints(scene, {}), plan, {});
}

TEST(VisibleSets, AWallHidesTheOtherRoom) {
  const TwoRooms rooms = two_rooms(0);
  const BatchPlan plan = plan_in(rooms.scene);
  ASSERT_EQ(batches_of(plan, rooms.left).size(), 1u);
  const VisibleSets sets = sets_of(rooms.scene, plan);
  EXPECT_EQ(seen_from_the_right(sets, plan, rooms.left), 0);
  EXPECT_EQ(seen_from_the_right(sets, plan, rooms.right), 1);
  EXPECT_GT(sets.checked, 1000u);
  EXPECT_LE(static_cast<double>(sets.missed), 1e-3 * static_cast<double>(sets.checked));
}

TEST(VisibleSets, AGapShowsIt) {
  const TwoRooms rooms = two_rooms(4);
  const BatchPlan plan = plan_in(rooms.scene);
  const double seen = seen_from_the_right(sets_of(rooms.scene, plan), plan, rooms.left);
  EXPECT_GT(seen, 0.05);
  EXPECT_LT(seen, 0.9);
}

TEST(VisibleSets, WhatIsSeenThroughHidesNothing) {
  const TwoRooms rooms = two_rooms(0, scene::AlphaMode::kMask);
  const BatchPlan plan = plan_in(rooms.scene);
  EXPECT_EQ(seen_from_the_right(sets_of(rooms.scene, plan), plan, rooms.left), 1);
}

TEST(VisibleSets, WallsOfOneSideHideFromThatSideOnly) {
  for (const Wall wall : {Wall::kFacesRight, Wall::kFacesLeft}) {
    const TwoRooms rooms = two_rooms(0, scene::AlphaMode::kOpaque, wall);
    const BatchPlan plan = plan_in(rooms.scene);
    EXPECT_EQ(seen_from_the_right(sets_of(rooms.scene, plan), plan, rooms.left),
              wall == Wall::kFacesRight ? 0 : 1);
  }
}

/// Every cell that a wall cuts is a place on both of its sides, however little of it lies on one.
TEST(VisibleSets, CellsOnAWallSeeBothRooms) {
  for (const float at : {0.3f, -0.05f})
    for (const Wall wall : {Wall::kThick, Wall::kFacesRight, Wall::kFacesLeft}) {
      const TwoRooms rooms = two_rooms(0, scene::AlphaMode::kOpaque, wall, at);
      const BatchPlan plan = plan_in(rooms.scene);
      int cells = 0;
      for (const ViewCell& cell : sets_of(rooms.scene, plan).cells) {
        if (cell.box.lower.x > at - 0.11f || cell.box.upper.x < at + 0.11f ||
            cell.box.upper.y > 2.5f || cell.box.upper.z > 10)
          continue;
        ++cells;
        for (const std::uint32_t object : {rooms.left, rooms.right})
          for (const std::uint32_t b : batches_of(plan, object))
            EXPECT_TRUE(std::binary_search(cell.seen.begin(), cell.seen.end(), b));
      }
      EXPECT_GT(cells, 0);
    }
}

TEST(VisibleSets, WhatMayMoveHidesNothing) {
  const TwoRooms rooms = two_rooms(0);
  BatchOptions options;
  options.traits.resize(rooms.scene.objects.size());
  options.traits[rooms.wall].keep = "moved by physics";
  const BatchPlan plan = plan_in(rooms.scene, options);
  ASSERT_TRUE(batches_of(plan, rooms.wall).empty());
  EXPECT_EQ(seen_from_the_right(sets_of(rooms.scene, plan), plan, rooms.left), 1);
}

TEST(VisibleSets, WhatMayOpenHidesNothing) {
  const TwoRooms rooms = two_rooms(0);
  const BatchPlan plan = plan_in(rooms.scene);
  VisibleSetOptions options;
  options.opens.resize(rooms.scene.objects.size());
  options.opens[rooms.wall] = true;
  const VisibleSets sets = *find_visible_sets(rooms.scene, hierarchy_of(rooms.scene),
                                              Viewpoints(rooms.scene, {}), plan, options);
  EXPECT_EQ(seen_from_the_right(sets, plan, rooms.left), 1);
}

/// Viewers draw what lies in one plane as it comes.
TEST(VisibleSets, WhatLiesInTheWallIsSeen) {
  for (const bool first : {false, true}) {
    SceneBuilder builder;
    builder.add_box({0, -0.2f, 0}, {10, 0, 10});
    const std::uint32_t paper = builder.add_material(), paint = builder.add_material();
    std::uint32_t picture = 0;
    const auto hang = [&] {
      picture = builder.add_wall({1, 1, 4.3f}, {1, 1.7f, 5.1f}, true, paper);
    };
    if (first) hang();
    builder.add_wall({1, 0, 0}, {1, 3, 10}, true, paint);
    if (!first) hang();
    const scene::Scene scene = builder.take();
    const BatchPlan plan = plan_in(scene);
    EXPECT_EQ(seen_from_the_right(sets_of(scene, plan), plan, picture), 1);
  }
}

TEST(VisibleSets, SameOnAnyNumberOfThreads) {
  const TwoRooms rooms = two_rooms(4);
  const BatchPlan plan = plan_in(rooms.scene);
  const VisibleSets many = sets_of(rooms.scene, plan);
  const int before = thread_count();
  set_thread_count(1);
  const VisibleSets one = sets_of(rooms.scene, plan);
  set_thread_count(before);
  ASSERT_EQ(one.cells.size(), many.cells.size());
  for (std::size_t i = 0; i < one.cells.size(); ++i)
    EXPECT_EQ(one.cells[i].seen, many.cells[i].seen);
  EXPECT_EQ(one.missed, many.missed);
}

TEST(VisibleSets, NothingToStandOnGivesNoCell) {
  scene::Scene none;
  const VisibleSets sets = sets_of(none, BatchPlan{});
  EXPECT_TRUE(sets.cells.empty());
  EXPECT_EQ(sets.rays, 0u);
}

}  // namespace
}  // namespace lightbatch::batches
