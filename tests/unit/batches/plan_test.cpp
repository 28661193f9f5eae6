#include "core/batches/plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/base/parallel.h"
#include "core/batches/measure.h"
#include "tests/unit/batches/plans.h"
#include "tests/unit/batches/scenes.h"

namespace lightbatch::batches {
namespace {

using testing::expect_complete;
using testing::grid_scene;
using testing::hierarchy_of;
using testing::plan_of;
using testing::SceneBuilder;

TEST(Plan, MergesSmallObjectsAndKeepsThemWhole) {
  const auto scene = grid_scene(12, 3);
  const BatchPlan p = plan_of(scene);
  expect_complete(scene, p);
  EXPECT_EQ(p.draws_before, 145u);
  EXPECT_LT(p.draws_after, 15u);
  // The floor may pay for a split; boxes of 12 triangles never do.
  EXPECT_LE(p.split_objects, 1u);
}

TEST(Plan, DearTrianglesMakeMoreBatches) {
  const auto scene = grid_scene(12, 1, 6);
  Profile cheap, dear;
  cheap.triangle = 1e-6;
  cheap.vertex = 0;
  dear.triangle = 0.5;
  const BatchPlan few = plan_of(scene, {}, cheap), many = plan_of(scene, {}, dear);
  expect_complete(scene, many);
  EXPECT_EQ(few.batches.size(), 1u);
  EXPECT_GT(many.batches.size(), 10u);
  EXPECT_LT(many.expected_triangles, few.expected_triangles);
  const auto tree = hierarchy_of(scene);
  const ViewsReport report =
      measure_views(scene, make_view_set(scene, tree, Viewpoints(scene, dear)), many);
  EXPECT_LT(report.after.inside.triangles, 2.0 * report.ideal_inside);
  EXPECT_GE(report.after.inside.triangles, report.ideal_inside);
  EXPECT_GE(report.before.inside.triangles, report.ideal_inside);
}

TEST(Plan, LimitOfBatches) {
  const auto scene = grid_scene(12, 1, 6);
  Profile dear;
  dear.triangle = 0.5;
  for (const std::uint32_t limit : {1u, 3u, 7u}) {
    BatchOptions options;
    options.max_batches = limit;
    const BatchPlan p = plan_of(scene, options, dear);
    expect_complete(scene, p);
    EXPECT_LE(p.batches.size(), limit);
    EXPECT_GE(p.batches.size(), 1u);
  }
}

TEST(Plan, PagesAndLayoutsSeparate) {
  const auto scene = grid_scene(4);
  BatchOptions options;
  options.traits.resize(scene.objects.size());
  options.traits[3].layout = 1;
  options.page_of_triangle.assign(scene.triangles.size(), 0);
  for (std::size_t t = scene.triangles.size() / 2; t < scene.triangles.size(); ++t)
    options.page_of_triangle[t] = 1;
  const BatchPlan p = plan_of(scene, options);
  expect_complete(scene, p);
  std::set<std::pair<std::uint32_t, std::uint32_t>> keys;
  for (const Batch& batch : p.batches)
    for (const Group& group : batch.groups) keys.insert({group.layout, group.page});
  EXPECT_EQ(keys.size(), 3u);
}

TEST(Plan, BlendedAndPinnedObjectsAreLeftWithAReason) {
  SceneBuilder builder;
  const std::uint32_t glass = builder.add_material(scene::AlphaMode::kBlend);
  builder.add_box({0, 0, 0}, {1, 1, 1});
  builder.add_box({2, 0, 0}, {3, 1, 1}, glass);
  builder.add_box({4, 0, 0}, {5, 1, 1});
  const auto scene = builder.take();
  BatchOptions options;
  options.traits.resize(3);
  options.traits[2].keep = "node extension X";
  const BatchPlan p = plan_of(scene, options);
  expect_complete(scene, p);
  ASSERT_EQ(p.left_alone.size(), 2u);
  EXPECT_EQ(p.left_alone[0].object, 1u);
  EXPECT_EQ(p.left_alone[1].reason, "node extension X");
}

TEST(Plan, BlendedObjectsAreCutButNeverMerged) {
  SceneBuilder builder;
  const std::uint32_t glass = builder.add_material(scene::AlphaMode::kBlend);
  builder.add_box({0, 0, 0}, {40, 1, 40});
  const auto large = builder.add_box({0, 1, 0}, {40, 4, 40}, glass, 0, 40);
  const auto small = builder.add_box({10, 1, 10}, {11, 2, 11}, glass);
  const auto scene = builder.take();
  Profile dear;
  dear.triangle = 0.5;
  const BatchPlan p = plan_of(scene, {}, dear);
  expect_complete(scene, p);
  ASSERT_EQ(p.left_alone.size(), 1u);
  EXPECT_EQ(p.left_alone[0].object, small);
  std::size_t parts = 0;
  for (const Batch& batch : p.batches)
    for (const Group& group : batch.groups)
      if (group.material == glass) {
        ++parts;
        EXPECT_EQ(group.pieces.front().object, large);
      }
  EXPECT_GT(parts, 4u);
}

/// 40 copies of a mesh of 12 cells^2 triangles far apart, and one 12-triangle box.
scene::Scene instanced_scene(int cells, bool own_material = false) {
  SceneBuilder builder;
  builder.add_box({0, 0, 0}, {1, 1, 1});
  const std::uint32_t material = own_material ? builder.add_material() : 0;
  for (int i = 0; i < 40; ++i) {
    const float x = 10.0f * static_cast<float>(i);
    builder.add_box({x, 0, 3}, {x + 1, 1, 4}, material, 7, cells);
  }
  return builder.take();
}

TEST(Plan, CopiesAreMadeWhereTheySaveDrawsCheaply) {
  // 24 KB for each saved draw are too dear; 4 KB are not, but few draws need no copies.
  const auto dear = instanced_scene(10), cheap = instanced_scene(4);
  BatchOptions options;
  options.max_growth = 50;
  for (const auto* scene : {&dear, &cheap}) {
    const BatchPlan kept = plan_of(*scene, options);
    expect_complete(*scene, kept);
    EXPECT_EQ(kept.copied_bytes, 0);
    ASSERT_FALSE(kept.cells.empty());
    EXPECT_LT(kept.draws_after, kept.draws_before);
  }
  options.free_draws = 0;
  options.draws_share = 1e-3;
  const BatchPlan copied = plan_of(cheap, options);
  expect_complete(cheap, copied);
  EXPECT_TRUE(copied.cells.empty());
  EXPECT_TRUE(copied.left_alone.empty());
  EXPECT_GT(copied.copied_bytes, 10 * copied.geometry_bytes);

  // Copies that share no draw with another mesh save nothing that instances do not.
  const auto alone = instanced_scene(4, true);
  const BatchPlan instanced = plan_of(alone, options);
  expect_complete(alone, instanced);
  EXPECT_EQ(instanced.copied_bytes, 0);
  EXPECT_FALSE(instanced.cells.empty());
}

TEST(Plan, CopiesStayWithinTheAllowedGrowth) {
  const auto scene = instanced_scene(4);
  BatchOptions options;
  options.max_growth = 5;
  const BatchPlan bounded = plan_of(scene, options);
  expect_complete(scene, bounded);
  EXPECT_LE(bounded.copied_bytes, 4 * bounded.geometry_bytes);
  EXPECT_FALSE(bounded.cells.empty());

  options.page_of_triangle.assign(scene.triangles.size(), 0);
  const BatchPlan lit = plan_of(scene, options);
  expect_complete(scene, lit);
  EXPECT_TRUE(lit.cells.empty());
  EXPECT_EQ(lit.left_alone.size(), 40u);
}

TEST(Plan, WithLightEachPrimitiveOfASharedMeshHasItsOwnFate) {
  // Twelve rooms: a floor of 4,800 triangles and a door of 12.
  SceneBuilder builder;
  const std::uint32_t wood = builder.add_material();
  for (int i = 0; i < 12; ++i) {
    const float x = 30.0f * static_cast<float>(i);
    builder.add_box({x, 0, 0}, {x + 29, 0.1f, 60}, 0, 7, 20);
    builder.add_box({x, 0, 0}, {x + 1, 2, 0.1f}, wood, 7);
  }
  auto scene = builder.take();
  for (std::uint32_t o = 0; o < scene.objects.size(); ++o) {
    scene.objects[o].node = o / 2;
    scene.objects[o].primitive = o % 2;
  }
  BatchOptions options;
  options.max_growth = 4;
  options.page_of_triangle.assign(scene.triangles.size(), 0);
  const BatchPlan p = plan_of(scene, options);
  expect_complete(scene, p);
  EXPECT_GT(p.copied_bytes, 0);
  EXPECT_LT(p.copied_bytes, 0.1 * p.geometry_bytes);
  EXPECT_FALSE(p.batches.empty());
  ASSERT_EQ(p.left_alone.size(), 12u);
  for (const LeftAlone& left : p.left_alone) EXPECT_EQ(scene.objects[left.object].primitive, 0u);
}

TEST(Plan, LargeSharedMeshesAreCutIntoPartsAndCells) {
  SceneBuilder builder;
  for (int i = 0; i < 12; ++i) {
    const float x = 30.0f * static_cast<float>(i);
    builder.add_box({x, 0, 0}, {x + 29, 0.1f, 60}, 0, 7, 40);
  }
  const auto scene = builder.take();
  Profile dear;
  dear.triangle = 0.05;
  const BatchPlan p = plan_of(scene, {}, dear);
  expect_complete(scene, p);
  EXPECT_GT(p.parts.size(), 1u);
  EXPECT_GT(p.cells.size(), p.parts.size());
  EXPECT_EQ(p.copied_bytes, 0);
}

TEST(Plan, MaterialsOfOneClassShareDraws) {
  SceneBuilder builder;
  const std::uint32_t other = builder.add_material();
  for (int i = 0; i < 8; ++i) {
    const float x = 2.0f * static_cast<float>(i);
    builder.add_box({x, 0, 0}, {x + 1, 1, 1}, i % 2 == 0 ? 0 : other);
  }
  const auto scene = builder.take();
  EXPECT_EQ(plan_of(scene).draws_after, 2u);
  BatchOptions options;
  options.traits.resize(8);
  for (ObjectTraits& t : options.traits) t.material_class = 0;
  const BatchPlan p = plan_of(scene, options);
  ASSERT_EQ(p.draws_after, 1u);
  EXPECT_TRUE(p.batches[0].groups[0].coloured);
}

TEST(Plan, CamerasAreTheViewsThatItIsMadeFor) {
  // 20 x 20 boxes, and one camera that sees those of one corner.
  const auto scene = grid_scene(20, 1, 6);
  Profile dear;
  dear.triangle = 0.5;
  const auto cameras = *read_cameras(R"([{"eye": [0, 1, 0], "target": [-1, 1, -1]},
                                         {"eye": [9, 1, 9], "target": [0, 1, 0], "weight": 3}])",
                                     "c", scene.origin);
  const Viewpoints viewpoints(scene, dear, cameras);
  const ViewSet views = make_view_set(scene, hierarchy_of(scene), viewpoints);
  ASSERT_EQ(views.inside, 2u);
  EXPECT_EQ(views.outside, 0u);
  BatchOptions options;
  const auto cost = [&](const Viewpoints& made_for) {
    const auto plan = *batches::plan(scene, hierarchy_of(scene), made_for, options);
    expect_complete(scene, plan);
    return measure_draws(views, draws_of_plan(scene, plan)).inside.cost;
  };
  EXPECT_LT(cost(viewpoints), 0.9 * cost(Viewpoints(scene, dear)));
}

TEST(Plan, SameOnAnyNumberOfThreads) {
  const auto scene = grid_scene(10, 4, 4);
  Profile dear;
  dear.triangle = 0.05;
  const int threads = thread_count();
  set_thread_count(1);
  const BatchPlan one = plan_of(scene, {}, dear);
  set_thread_count(3);
  const BatchPlan three = plan_of(scene, {}, dear);
  set_thread_count(threads);
  ASSERT_EQ(one.batches.size(), three.batches.size());
  EXPECT_EQ(one.expected_triangles, three.expected_triangles);
  for (std::size_t b = 0; b < one.batches.size(); ++b) {
    EXPECT_EQ(one.batches[b].box, three.batches[b].box);
    ASSERT_EQ(one.batches[b].groups.size(), three.batches[b].groups.size());
    for (std::size_t g = 0; g < one.batches[b].groups.size(); ++g)
      EXPECT_EQ(one.batches[b].groups[g].pieces.size(), three.batches[b].groups[g].pieces.size());
  }
}

TEST(Plan, EmptySceneGivesAnEmptyPlan) {
  const BatchPlan p = plan_of(scene::Scene{});
  EXPECT_TRUE(p.batches.empty());
  EXPECT_TRUE(p.tree.empty());
  EXPECT_EQ(p.draws_before, 0u);
}

TEST(Plan, CurveFallsMonotonically) {
  const BatchPlan p = plan_of(grid_scene(16, 2, 4));
  ASSERT_GT(p.curve.size(), 3u);
  for (std::size_t i = 1; i < p.curve.size(); ++i) {
    EXPECT_GE(p.curve[i].draws, p.curve[i - 1].draws);
    EXPECT_LE(p.curve[i].triangles, p.curve[i - 1].triangles);
  }
}

TEST(Plan, BadOptions) {
  const auto scene = grid_scene(2);
  BatchOptions options;
  options.max_growth = 0.5;
  EXPECT_EQ(plan(scene, hierarchy_of(scene), Viewpoints(scene, {}), options).status().reason(),
            "BAD_OPTION");
  options = {};
  options.max_vertices = 2;
  EXPECT_EQ(plan(scene, hierarchy_of(scene), Viewpoints(scene, {}), options).status().reason(),
            "BAD_OPTION");
}

}  // namespace
}  // namespace lightbatch::batches
