#include <gtest/gtest.h>

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

TEST(DrawsShare, ManyDrawsAreBroughtToTheAllowedShare) {
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
  EXPECT_LE(mean(bounded), 0.1 * before);
}

TEST(DrawsShare, MoreIsCopiedWhereInstancesCannotReachTheShareOfDraws) {
  // 40 meshes in 16 places each, 18 KB for each saved draw: instances take a call for each mesh.
  SceneBuilder builder;
  std::uint32_t at = 0;
  for (int place = 0; place < 16; ++place)
    for (std::uint32_t mesh = 1; mesh <= 40; ++mesh, ++at) {
      const auto x = static_cast<float>(at * 7 % 26), z = static_cast<float>(at * 11 % 25);
      builder.add_box({2 * x, 0, 2 * z}, {2 * x + 1, 0.3f, 2 * z + 1}, 0, mesh, 9);
    }
  const auto scene = builder.take();
  BatchOptions options;
  const BatchPlan reached = plan_of(scene, options);
  expect_complete(scene, reached);
  options.draws_share = 1;
  const BatchPlan free = plan_of(scene, options);
  EXPECT_EQ(free.copied_bytes, 0);
  EXPECT_GT(reached.copied_bytes, 0);
  EXPECT_LE(reached.copied_bytes, (options.max_growth - 1) * reached.geometry_bytes);
  const ViewSet views = make_view_set(scene, hierarchy_of(scene), Viewpoints(scene, {}));
  const auto mean = [&](const BatchPlan& plan) {
    return measure_draws(views, draws_of_plan(scene, plan)).inside;
  };
  const double before = measure_draws(views, draws_of_input(scene)).inside.draws;
  EXPECT_LE(mean(reached).draws, 0.1 * before);
  EXPECT_LE(mean(reached).triangles, 2 * views.ideal_inside);
}

TEST(DrawsShare, NoMoreIsCopiedThanTheShareNeeds) {
  // 10 meshes in 80 places all over, and two larger ones side by side, which instances draw as
  // well.
  constexpr std::uint32_t kPlaces = 80;
  SceneBuilder builder;
  const auto add = [&](std::uint32_t at, std::uint32_t mesh, int cells) {
    const auto x = static_cast<float>(at % 32), z = static_cast<float>(at / 32);
    builder.add_box({2 * x, 0, 2 * z}, {2 * x + 1, 0.3f, 2 * z + 1}, 0, mesh, cells);
  };
  for (std::uint32_t i = 0; i < 10 * kPlaces; ++i) add(i, 1 + i * 7 % 60, 2);
  for (std::uint32_t i = 0; i < 2 * kPlaces; ++i) add(10 * kPlaces + i, 61 + i / kPlaces, 6);
  const auto scene = builder.take();
  BatchOptions options;
  options.max_growth = 2 * kPlaces;
  const BatchPlan plan = plan_of(scene, options);
  expect_complete(scene, plan);
  options.draws_share = 1e-6;
  const double all_copies = plan_of(scene, options).copied_bytes;
  EXPECT_GT(plan.copied_bytes, 0);
  EXPECT_LT(plan.copied_bytes, 0.5 * all_copies);
  const ViewSet views = make_view_set(scene, hierarchy_of(scene), Viewpoints(scene, {}));
  const ViewFigures inside = measure_draws(views, draws_of_plan(scene, plan)).inside;
  EXPECT_LE(inside.draws, 0.1 * measure_draws(views, draws_of_input(scene)).inside.draws);
  EXPECT_LE(inside.triangles, 2 * views.ideal_inside);
}

}  // namespace
}  // namespace lightbatch::batches
