#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/scene_in/scene_builder.h"

namespace lightbatch::scene_in {
namespace {

constexpr const char* kLights = "KHR_lights_punctual";
constexpr double kHalf = 0.70710678118654752;

SceneBuilder lit(const Json& light, Json node = Json::object()) {
  SceneBuilder builder;
  builder.square();
  node["extensions"][kLights]["light"] = 0;
  builder.json["nodes"].push_back(node);
  builder.json["scenes"][0]["nodes"] = {0, 1};
  builder.json["extensions"][kLights]["lights"] = Json::array({light});
  builder.json["extensionsUsed"] = {kLights};
  return builder;
}

TEST(Light, DefaultsAreThoseOfTheExtension) {
  const scene::Scene scene = read(lit({{"type", "point"}}));
  ASSERT_EQ(scene.lights.size(), 1u);
  const scene::Light& light = scene.lights[0];
  EXPECT_EQ(light.kind, scene::LightKind::kPoint);
  EXPECT_EQ(light.intensity, (Rgb{1, 1, 1}));
  EXPECT_EQ(light.range, 0);
  EXPECT_EQ(light.node, 1u);
  EXPECT_EQ(light.gltf_index, 0u);
}

TEST(Light, IsPlacedAndTurnedButNotScaled) {
  const scene::Scene scene =
      read(lit({{"type", "spot"},
                {"name", "stage"},
                {"color", {1, 0.5, 0.25}},
                {"intensity", 8},
                {"range", 20},
                {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}}},
               {{"translation", {1, 2, 3}},
                {"rotation", {kHalf, 0, 0, kHalf}},  // -z becomes +y
                {"scale", {4, 4, 4}}}));
  ASSERT_EQ(scene.lights.size(), 1u);
  const scene::Light& light = scene.lights[0];
  EXPECT_EQ(light.kind, scene::LightKind::kSpot);
  EXPECT_EQ(light.name, "stage");
  EXPECT_EQ(light.intensity, (Rgb{8, 4, 2}));
  EXPECT_EQ(light.range, 20);
  EXPECT_EQ(scene.origin + light.position, (Vec3d{1, 2, 3}));
  EXPECT_NEAR(light.direction.y, 1, 1e-12);
  EXPECT_NEAR(light.direction.z, 0, 1e-12);
  EXPECT_DOUBLE_EQ(light.cos_inner, std::cos(0.25));
  EXPECT_DOUBLE_EQ(light.cos_outer, std::cos(0.5));
}

TEST(Light, SpotDefaultsToAQuarterOfPi) {
  const scene::Scene scene = read(lit({{"type", "spot"}, {"spot", Json::object()}}));
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_EQ(scene.lights[0].cos_inner, 1);
  EXPECT_NEAR(scene.lights[0].cos_outer, std::cos(std::atan(1.0)), 1e-9);
}

TEST(Light, BadValuesAreMadeHarmless) {
  const scene::Scene scene =
      read(lit({{"type", "spot"},
                {"intensity", -5},
                {"color", {2, -1, 1}},
                {"spot", {{"innerConeAngle", 3}, {"outerConeAngle", 0.5}}}}));
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_EQ(scene.lights[0].intensity, (Rgb{0, 0, 0}));
  EXPECT_GE(scene.lights[0].cos_inner, scene.lights[0].cos_outer);
  EXPECT_EQ(scene.warnings.size(), 1u);
}

TEST(Light, ARangeOfZeroIsNoLimitAndSaid) {
  const scene::Scene scene = read(lit({{"type", "point"}, {"range", 0}}));
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_EQ(scene.lights[0].range, 0);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("range of 0"), std::string::npos);
  EXPECT_TRUE(read(lit({{"type", "point"}})).warnings.empty());
}

TEST(Light, FartherThanAnyMeshMayBeIsRefused) {
  for (const double x : {1e16, 1e39, 1e200}) {
    const auto document = lit({{"type", "point"}}, {{"translation", {1, x, 1}}}).read();
    ASSERT_TRUE(document.ok());
    const Status status = read_scene(*document, {}).status();
    EXPECT_EQ(status.reason(), "INPUT_MALFORMED") << x;
    EXPECT_NE(status.to_string().find("#/nodes/1"), std::string::npos) << status.to_string();
  }
  // Where a directional light hangs does not matter.
  const scene::Scene sun = read(lit({{"type", "directional"}}, {{"translation", {1, 1e39, 1}}}));
  ASSERT_EQ(sun.lights.size(), 1u);
  EXPECT_EQ(sun.lights[0].position, (Vec3d{}));
}

TEST(Light, UnknownTypesAreLeftOut) {
  const scene::Scene scene = read(lit({{"type", "spherical"}}));
  EXPECT_TRUE(scene.lights.empty());
  EXPECT_EQ(scene.warnings.size(), 1u);
}

TEST(Light, MovingLightsAreListed) {
  SceneBuilder builder = lit({{"type", "point"}});
  const std::size_t times = builder.accessor(std::vector<float>{0, 1}, "SCALAR", 1);
  const std::size_t places = builder.accessor(std::vector<float>{0, 0, 0, 1, 1, 1}, "VEC3", 3);
  builder.json["animations"] = {
      {{"channels", {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "translation"}}}}}},
       {"samplers", {{{"input", times}, {"output", places}}}}}};
  const scene::Scene scene = read(builder);
  EXPECT_TRUE(scene.lights.empty());
  ASSERT_EQ(scene.skipped.size(), 1u);
  EXPECT_EQ(scene.skipped[0].node, 1u);
  EXPECT_EQ(scene.skipped[0].reason, "animated");
}

TEST(Light, ChangingLightsAreListed) {
  SceneBuilder builder = lit({{"type", "point"}});
  builder.json["nodes"].push_back(builder.json["nodes"][1]);
  builder.json["nodes"][2]["extensions"][kLights]["light"] = 1;
  builder.json["scenes"][0]["nodes"].push_back(2);
  builder.json["extensions"][kLights]["lights"].push_back({{"type", "point"}});
  const std::size_t times = builder.accessor(std::vector<float>{0, 1}, "SCALAR", 1);
  const std::size_t values = builder.accessor(std::vector<float>{1, 9}, "SCALAR", 1);
  Json target{{"path", "pointer"}};
  target["extensions"]["KHR_animation_pointer"]["pointer"] =
      "/extensions/KHR_lights_punctual/lights/1/intensity";
  builder.json["animations"] = {{{"channels", {{{"sampler", 0}, {"target", target}}}},
                                 {"samplers", {{{"input", times}, {"output", values}}}}}};
  builder.json["extensionsUsed"].push_back("KHR_animation_pointer");
  const scene::Scene scene = read(builder);
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_EQ(scene.lights[0].node, 1u);
  ASSERT_EQ(scene.skipped.size(), 1u);
  EXPECT_EQ(scene.skipped[0].node, 2u);
}

}  // namespace
}  // namespace lightbatch::scene_in
