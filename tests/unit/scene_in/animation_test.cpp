#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/scene_in/scene_builder.h"

namespace lightbatch::scene_in {
namespace {

/// Key frames of one property of node 0.
void animate(SceneBuilder& builder, const char* path, const std::vector<float>& times,
             const std::vector<float>& values, const char* interpolation = "LINEAR") {
  const std::size_t components = std::string(path) == "rotation" ? 4 : 3;
  const std::size_t input = builder.accessor(times, "SCALAR", 1);
  const std::size_t output =
      builder.accessor(values, components == 4 ? "VEC4" : "VEC3", components);
  builder.json["animations"].push_back(
      {{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}}},
       {"samplers", {{{"input", input}, {"output", output}, {"interpolation", interpolation}}}}});
}

scene::MovingMesh moving(const SceneBuilder& builder) {
  const scene::Scene scene = read(builder);
  EXPECT_EQ(scene.moving.size(), 1u);
  return scene.moving.empty() ? scene::MovingMesh{} : scene.moving[0];
}

// The square of the builder spans (0, 0, 0) to (1, 1, 0).
TEST(Animation, TheWayHoldsRestAndKeyFrames) {
  SceneBuilder builder;
  builder.square();
  animate(builder, "translation", {0, 1, 3}, {0, 0, 0, 5, 0, 0, 5, -2, 0});
  animate(builder, "scale", {0, 1}, {1, 1, 1, 3, 1, 1});
  const scene::MovingMesh mesh = moving(builder);
  EXPECT_EQ(mesh.node, 0u);
  EXPECT_EQ(mesh.rest.upper, (Vec3d{1, 1, 0}));
  EXPECT_EQ(mesh.swept.lower, (Vec3d{0, -2, 0}));
  EXPECT_EQ(mesh.swept.upper, (Vec3d{6, 1, 0}));  // each animation on its own
}

// A quarter turn about z: between its key frames the far corner comes to the square's diagonal.
TEST(Animation, TurnsBulgeBetweenKeyFrames) {
  SceneBuilder builder;
  builder.square();
  const float half = std::sqrt(0.5f);
  animate(builder, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, half, half});
  const scene::MovingMesh mesh = moving(builder);
  EXPECT_NEAR(mesh.swept.upper.y, std::sqrt(2.0), 0.02 * std::sqrt(2.0));
  EXPECT_NEAR(mesh.swept.lower.x, -1, 1e-6);
  // The shorter way round, whatever the sign of the quaternion.
  SceneBuilder other;
  other.square();
  animate(other, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, -half, -half});
  EXPECT_NEAR(moving(other).swept.lower.x, -1, 1e-6);
  EXPECT_NEAR(moving(other).swept.lower.y, 0, 1e-6);
}

TEST(Animation, StepsJumpAndSplinesOvershoot) {
  SceneBuilder steps;
  steps.square();
  animate(steps, "translation", {0, 1}, {0, 0, 0, 0, 7, 0}, "STEP");
  EXPECT_EQ(moving(steps).swept.upper, (Vec3d{1, 8, 0}));
  // In-tangent, value, out-tangent: from rest to rest with a swing of 4 t (1 - t)^2 - ... = 1 at
  // t = 1/2 (tangents +4 and -4: h = 4 (t^3 - 2 t^2 + t) - 4 (t^3 - t^2) = 4 t (1 - t)).
  SceneBuilder spline;
  spline.square();
  animate(spline, "translation", {0, 1}, {0, 0, 0, 0, 0, 0, 0, 4, 0, 0, -4, 0, 0, 0, 0, 0, 0, 0},
          "CUBICSPLINE");
  EXPECT_NEAR(moving(spline).swept.upper.y, 2, 1e-6);
}

TEST(Animation, WhatHangsBelowMovesAlong) {
  SceneBuilder builder;
  builder.square();
  builder.json["nodes"] = {{{"children", {1}}}, {{"mesh", 0}, {"translation", {0, 0, 10}}}};
  animate(builder, "translation", {0, 1}, {0, 0, 0, 3, 0, 0});
  const scene::MovingMesh mesh = moving(builder);
  EXPECT_EQ(mesh.node, 1u);
  EXPECT_EQ(mesh.swept.lower, (Vec3d{0, 0, 10}));
  EXPECT_EQ(mesh.swept.upper, (Vec3d{4, 1, 10}));
}

TEST(Animation, SkinsFollowTheirJoints) {
  SceneBuilder builder;
  skinned_square(builder);
  builder.json["skins"] = {{{"joints", {1, 0}}}};
  builder.json["nodes"] = {
      {{"name", "joint"}}, {{"name", "joint"}}, {{"mesh", 0}, {"skin", 0}}, {{"children", {0, 1}}}};
  builder.json["scenes"][0]["nodes"] = {2, 3};
  animate(builder, "translation", {0, 1}, {0, 0, 0, 0, 0, 9});
  const scene::MovingMesh mesh = moving(builder);
  EXPECT_EQ(mesh.node, 2u);
  EXPECT_EQ(mesh.rest.upper.z, 0);
  EXPECT_EQ(mesh.swept.upper.z, 9);
}

TEST(Animation, MorphTargetsMix) {
  SceneBuilder builder;
  builder.square();
  const std::size_t up =
      builder.accessor(std::vector<float>{0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC3", 3);
  builder.primitive()["targets"] = {{{"POSITION", up}}, {{"POSITION", up}}};
  EXPECT_EQ(moving(builder).rest.upper.z, 4);
}

TEST(Animation, TooLongToFollowIsSaid) {
  SceneBuilder builder;
  builder.square();
  std::vector<float> times, values;
  for (int i = 0; i < 60000; ++i) {
    times.push_back(static_cast<float>(i));
    for (const float v : {0.0f, static_cast<float>(i % 7), 0.0f}) values.push_back(v);
  }
  animate(builder, "translation", times, values);
  EXPECT_NEAR(moving(builder).swept.upper.y, 7, 0.5);  // chosen moments are enough here
  const Json one = builder.json["animations"][0];
  for (int i = 0; i < 1000; ++i) builder.json["animations"].push_back(one);
  const scene::Scene scene = read(builder);
  ASSERT_EQ(scene.moving.size(), 1u);
  ASSERT_FALSE(scene.warnings.empty());
  EXPECT_NE(scene.warnings.back().find("too long to follow"), std::string::npos);
}

TEST(Animation, PlacesOutOfReachAreRefused) {
  SceneBuilder builder;
  builder.square();
  animate(builder, "translation", {0, 1}, {0, 0, 0, 1e30f, 0, 0});
  const auto document = builder.read();
  ASSERT_TRUE(document.ok());
  EXPECT_EQ(read_scene(*document).status().reason(), "INPUT_MALFORMED");
}

}  // namespace
}  // namespace lightbatch::scene_in
