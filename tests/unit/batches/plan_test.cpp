#include "core/batches/plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/base/parallel.h"
#include "core/batches/measure.h"
#include "tests/unit/batches/scenes.h"

namespace lightbatch::batches {
namespace {

using testing::grid_scene;
using testing::hierarchy_of;
using testing::SceneBuilder;

BatchPlan plan_of(const scene::Scene& scene, const BatchOptions& options = {},
                  const Profile& profile = {}) {
  auto result = plan(scene, hierarchy_of(scene), Viewpoints(scene, profile), options);
  EXPECT_TRUE(result.ok()) << result.status().to_string();
  return std::move(result).value();
}

/// Every triangle of an object is in one batch, a cell or left alone, and boxes are tight.
void expect_complete(const scene::Scene& scene, const BatchPlan& plan) {
  std::vector<int> times(scene.triangles.size(), 0);
  for (const Batch& batch : plan.batches) {
    Aabb all;
    std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> keys;
    for (const Group& group : batch.groups) {
      EXPECT_TRUE(keys.insert({group.material, group.layout, group.page}).second);
      Aabb box;
      std::uint64_t triangles = 0;
      for (const Piece& piece : group.pieces)
        for (const Range& range : piece.ranges)
          for (std::uint32_t t = range.first; t < range.first + range.count; ++t) {
            ++times[t];
            ++triangles;
            EXPECT_EQ(scene.triangles[t].object, piece.object);
            EXPECT_TRUE(group.coloured || scene.objects[piece.object].material == group.material);
            for (const Vec3f& p : scene.corners(t)) box.add(p);
          }
      EXPECT_EQ(triangles, group.triangles);
      EXPECT_EQ(box, group.box);
      all.add(box);
    }
    EXPECT_EQ(all, batch.box);
  }
  for (const InstanceCell& cell : plan.cells) {
    std::uint64_t triangles = 0;
    for (const std::uint32_t placed : cell.objects)
      for (const Piece& piece : plan.parts[cell.part].pieces)
        for (std::uint32_t o = 0; o < scene.objects.size(); ++o) {
          // The object of this placement that corresponds to the piece's.
          const scene::Object& object = scene.objects[o];
          const scene::Object& model = scene.objects[piece.object];
          if (object.node != scene.objects[placed].node || object.mesh != model.mesh ||
              object.instance != scene.objects[placed].instance ||
              object.primitive != model.primitive)
            continue;
          for (const Range& range : piece.ranges)
            for (std::uint32_t k = 0; k < range.count; ++k) {
              const std::uint32_t t =
                  object.first_triangle + range.first + k - model.first_triangle;
              ++times[t];
              ++triangles;
              for (const Vec3f& p : scene.corners(t)) {
                const Aabb corner{p, p};
                Aabb box = cell.box;
                box.add(corner);
                EXPECT_EQ(box, cell.box);
              }
            }
        }
    EXPECT_EQ(triangles, cell.triangles);
  }
  for (const LeftAlone& left : plan.left_alone) {
    EXPECT_FALSE(left.reason.empty());
    for (std::uint32_t k = 0; k < scene.objects[left.object].triangle_count; ++k)
      ++times[scene.objects[left.object].first_triangle + k];
  }
  EXPECT_EQ(std::count(times.begin(), times.end(), 1), static_cast<std::ptrdiff_t>(times.size()));
  std::set<std::uint32_t> in_tree;
  for (std::size_t i = 0; i < plan.tree.size(); ++i) {
    const TreeNode& node = plan.tree[i];
    if (node.batch != scene::kNone) {
      EXPECT_TRUE(in_tree.insert(node.batch).second);
    } else {
      EXPECT_GE(node.children.size(), 2u);
      for (const std::uint32_t child : node.children) EXPECT_GT(child, i);
    }
  }
  EXPECT_EQ(in_tree.size(), plan.batches.size());
}

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
  const ViewsReport report = measure_views(scene, tree, Viewpoints(scene, dear), many);
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
  // 24 KB for each saved draw are too dear, 4 KB are not.
  const auto dear = instanced_scene(10), cheap = instanced_scene(4);
  BatchOptions options;
  options.max_growth = 50;
  const BatchPlan kept = plan_of(dear, options), copied = plan_of(cheap, options);
  expect_complete(dear, kept);
  EXPECT_EQ(kept.copied_bytes, 0);
  ASSERT_FALSE(kept.cells.empty());
  EXPECT_LT(kept.draws_after, kept.draws_before);
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

TEST(Plan, ManyDrawsAreBroughtToTheAllowedShare) {
  // 30 x 30 boxes of 432 triangles: cost alone would draw far more often.
  const auto scene = grid_scene(30, 1, 6);
  Profile dear;
  dear.triangle = 0.5;
  BatchOptions options;
  const BatchPlan bounded = plan_of(scene, options, dear);
  expect_complete(scene, bounded);
  options.draws_share = 1;
  const BatchPlan free = plan_of(scene, options, dear);
  EXPECT_GT(bounded.draw_price, free.draw_price);
  const ViewSet views = make_view_set(scene, hierarchy_of(scene), Viewpoints(scene, dear));
  const auto mean = [&](const BatchPlan& plan) {
    return measure_draws(views, draws_of_plan(scene, plan)).inside.draws;
  };
  const double before = measure_draws(views, draws_of_input(scene)).inside.draws;
  EXPECT_GT(mean(free), 0.2 * before);
  // The model is a mean over fewer eyes than the measure.
  EXPECT_LT(mean(bounded), 0.12 * before);
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
