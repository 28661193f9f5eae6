#include "core/batches/views.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "tests/unit/batches/scenes.h"

namespace lightbatch::batches {
namespace {

TEST(Frustum, LooksAlongItsYawAndPitch) {
  const Profile profile;
  const Frustum ahead({{0, 0, 0}, 0, 0, true}, profile);
  EXPECT_FALSE(ahead.outside(Aabb{{-1, -1, 9}, {1, 1, 10}}));
  EXPECT_TRUE(ahead.outside(Aabb{{-1, -1, -10}, {1, 1, -9}}));
  EXPECT_TRUE(ahead.outside(Aabb{{40, -1, 9}, {41, 1, 10}}));
  // 30 degrees up is the edge of the field: tan = 0.577.
  EXPECT_TRUE(ahead.outside(Aabb{{-1, 5.9f, 9}, {1, 6, 10}}));
  EXPECT_FALSE(ahead.outside(Aabb{{-1, 5.1f, 9}, {1, 6, 10}}));
  const Frustum right({{0, 0, 0}, std::numbers::pi / 2, 0, true}, profile);
  EXPECT_FALSE(right.outside(Aabb{{9, -1, -1}, {10, 1, 1}}));
  const Frustum up({{0, 0, 0}, 0, 1.2, true}, profile);
  EXPECT_FALSE(up.outside(Aabb{{-1, 9, 2}, {1, 10, 4}}));
  EXPECT_TRUE(up.outside(Aabb{{-1, -10, 2}, {1, -9, 4}}));
}

TEST(Frustum, HoldsImpliesEveryPointInside) {
  const Frustum frustum({{1, 2, 3}, 0.7, -0.2, true}, Profile{});
  Random random(1);
  int held = 0;
  for (int i = 0; i < 2000; ++i) {
    Aabb box;
    const Vec3f at{random.next_float() * 20 - 10, random.next_float() * 20 - 10,
                   random.next_float() * 20 - 10};
    box.add(at);
    box.add(at + Vec3f{random.next_float(), random.next_float(), random.next_float()});
    std::uint32_t planes = Frustum::kAllPlanes;
    if (frustum.outside(box, planes) || planes != 0) continue;
    ++held;
    EXPECT_FALSE(frustum.outside(box));
    const Vec3d a = to_double(box.lower), b = to_double(box.upper);
    EXPECT_FALSE(frustum.outside(a, a, a));
    EXPECT_FALSE(frustum.outside(b, b, b));
  }
  EXPECT_GT(held, 20);
}

TEST(ViewDistribution, GrowsWithTheBoxAndIsOneForAll) {
  const auto scene = testing::grid_scene(6);
  const ViewDistribution views(Viewpoints(scene, {}));
  EXPECT_GT(views.visible(scene.box), 0.95);
  EXPECT_EQ(views.visible(Aabb{}), 0);
  Aabb box{{4, 0, 4}, {4.1f, 0.1f, 4.1f}};
  double last = 0;
  for (int i = 0; i < 8; ++i) {
    const double chance = views.visible(box);
    EXPECT_GE(chance, last);
    EXPECT_LE(chance, 1);
    last = chance;
    box.add(box.upper + Vec3f{1, 0.1f, 1});
  }
}

/// The analytic chance against counting frusta over the same distribution of directions.
TEST(ViewDistribution, AgreesWithCounting) {
  const auto scene = testing::grid_scene(6);
  Profile profile;
  profile.inside = 1;
  const Viewpoints viewpoints(scene, profile);
  const ViewDistribution views(viewpoints);
  const auto eyes = viewpoints.standing_eyes(32, 0);
  ASSERT_EQ(eyes.size(), 32u);
  for (const Aabb& box : {Aabb{{0, 0, 0}, {1, 1, 1}}, Aabb{{6, 0, 6}, {10, 1, 7}}}) {
    Random random(3);
    int seen = 0;
    const int trials = 20000;
    for (int i = 0; i < trials; ++i) {
      const View view{eyes[static_cast<std::size_t>(i) % eyes.size()],
                      random.next_double() * 2 * std::numbers::pi,
                      (random.next_double() * 2 - 1) * 20 * std::numbers::pi / 180, true};
      seen += Frustum(view, profile).outside(box) ? 0 : 1;
    }
    // Corners of the frustum and of the box are not independent in yaw and pitch: within 0.06.
    EXPECT_NEAR(views.visible(box), static_cast<double>(seen) / trials, 0.06);
  }
}

TEST(Views, EyesStandOnFloors) {
  const auto scene = testing::grid_scene(4);
  for (const Vec3d& eye : Viewpoints(scene, {}).standing_eyes(50, 0)) {
    EXPECT_GT(eye.y, 0);
    EXPECT_LE(eye.y, 1.5);
  }
  const scene::Scene none;
  EXPECT_TRUE(Viewpoints(none, {}).standing_eyes(5, 0).empty());
  EXPECT_TRUE(Viewpoints(none, {}).sample(5, 5).empty());
  EXPECT_EQ(Viewpoints(scene, {}).sample(5, 3).size(), 8u);
}

TEST(Cameras, AreReadInWorldCoordinates) {
  const auto cameras = read_cameras(R"([{"eye": [11, 2, 3], "target": [11, 2, 8]},
                       {"eye": [10, 0, 0], "target": [11, 1, 0], "weight": 2.5}])",
                                    "c.json", {10, 0, 0});
  ASSERT_TRUE(cameras.ok());
  ASSERT_EQ(cameras->size(), 2u);
  EXPECT_EQ((*cameras)[0].eye, (Vec3d{1, 2, 3}));
  EXPECT_NEAR((*cameras)[0].yaw, 0, 1e-12);
  EXPECT_EQ((*cameras)[0].weight, 1);
  EXPECT_NEAR((*cameras)[1].yaw, std::numbers::pi / 2, 1e-12);
  EXPECT_NEAR((*cameras)[1].pitch, std::numbers::pi / 4, 1e-12);
  EXPECT_EQ((*cameras)[1].weight, 2.5);
}

TEST(Cameras, BadJsonSaysWhere) {
  for (const auto& [text, place] :
       {std::pair{"{}", "c"},
        {"[]", "c"},
        {"[3]", "c#/0"},
        {R"([{"eye": [0, 0, 0]}])", "c#/0/target"},
        {R"([{"eye": [0, 0], "target": [1, 0, 0]}])", "c#/0/eye"},
        {R"([{"eye": [0, 0, 1], "target": [0, 0, 1]}])", "c#/0/target"},
        {R"([{"eye": [0, 0, 1], "target": [0, 0, 2], "weight": 0}])", "c#/0/weight"},
        {R"([{"eye": [0, 0, 1], "target": [0, 0, 2], "fov": 3}])", "c#/0/fov"}}) {
    const auto cameras = read_cameras(text, "c", {});
    ASSERT_FALSE(cameras.ok()) << text;
    EXPECT_EQ(cameras.status().place(), place);
  }
}

/// With many cameras their weights decide how often a box is seen.
TEST(ViewDistribution, DrawsManyCamerasByWeight) {
  const auto scene = testing::grid_scene(4);
  std::vector<View> cameras(1000);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    cameras[i].eye = {0, 0.5, 0};
    cameras[i].yaw = i % 2 == 0 ? 0 : std::numbers::pi;
    cameras[i].inside = true;
    cameras[i].weight = i % 2 == 0 ? 1 : 3;
  }
  const ViewDistribution views(Viewpoints(scene, {}, cameras));
  EXPECT_NEAR(views.visible(Aabb{{-1, 0, 9}, {1, 1, 10}}), 0.25, 0.01);
  EXPECT_NEAR(views.visible(Aabb{{-1, 0, -10}, {1, 1, -9}}), 0.75, 0.01);
}

}  // namespace
}  // namespace lightbatch::batches
