#include <gtest/gtest.h>

#include "tests/unit/scene_in/scene_builder.h"

namespace lightbatch::scene_in {
namespace {

void animate(SceneBuilder& builder, int node, const char* path) {
  const std::size_t times = builder.accessor(std::vector<float>{0, 1}, "SCALAR", 1);
  const std::size_t values = builder.accessor(std::vector<float>{0, 0, 0, 1, 1, 1}, "VEC3", 3);
  builder.json["animations"].push_back(
      {{"channels", {{{"sampler", 0}, {"target", {{"node", node}, {"path", path}}}}}},
       {"samplers", {{{"input", times}, {"output", values}}}}});
}

TEST(Skipped, LinesPointsAndMeshesWithoutPositions) {
  SceneBuilder builder;
  builder.square();
  const Json primitive = builder.primitive();
  Json& primitives = builder.json["meshes"][0]["primitives"];
  for (const int mode : {0, 1, 2, 3}) {
    primitives.push_back(primitive);
    primitives.back()["mode"] = mode;
  }
  primitives.push_back({{"attributes", {{"NORMAL", 0}}}});
  const scene::Scene scene = read(builder);
  EXPECT_EQ(scene.triangles.size(), 2u);
  std::vector<std::string> reasons;
  for (const scene::Skipped& skipped : scene.skipped) reasons.push_back(skipped.reason);
  EXPECT_EQ(reasons,
            (std::vector<std::string>{"POINTS", "LINES", "LINES", "LINES", "no positions"}));
  EXPECT_EQ(scene.skipped[4].primitive, 5u);
  EXPECT_TRUE(scene.moving.empty());
}

TEST(Skipped, AnimatedNodesAndAllBelow) {
  SceneBuilder builder;
  builder.square();
  builder.json["nodes"] = {
      {{"children", {1}}, {"translation", {10, 0, 0}}}, {{"mesh", 0}}, {{"mesh", 0}}};
  builder.json["scenes"][0]["nodes"] = {0, 2};
  animate(builder, 0, "translation");
  const scene::Scene scene = read(builder);
  ASSERT_EQ(scene.objects.size(), 1u);
  EXPECT_EQ(scene.objects[0].node, 2u);
  ASSERT_EQ(scene.skipped.size(), 1u);
  EXPECT_EQ(scene.skipped[0].node, 1u);
  EXPECT_EQ(scene.skipped[0].reason, "animated");
  ASSERT_EQ(scene.moving.size(), 1u);
  EXPECT_EQ(scene.moving[0].rest.lower, (Vec3d{10, 0, 0}));
  EXPECT_EQ(scene.moving[0].rest.upper, (Vec3d{11, 1, 0}));
}

TEST(Skipped, AnimationPointersMoveNodesToo) {
  SceneBuilder builder;
  builder.square();
  animate(builder, 0, "pointer");
  Json& target = builder.json["animations"][0]["channels"][0]["target"];
  target.erase("node");
  target["extensions"]["KHR_animation_pointer"]["pointer"] = "/nodes/0/rotation";
  builder.json["extensionsUsed"] = {"KHR_animation_pointer"};
  EXPECT_EQ(read(builder).skipped.size(), 1u);
  builder.json["animations"][0]["channels"][0]["target"]["extensions"]["KHR_animation_pointer"]
              ["pointer"] = "/materials/0/emissiveFactor";
  EXPECT_TRUE(read(builder).skipped.empty());
}

TEST(Skipped, HiddenNodesAndAllBelow) {
  SceneBuilder builder;
  builder.square();
  Json lamp;
  lamp["extensions"]["KHR_lights_punctual"]["light"] = 0;
  builder.json["nodes"] = {{{"children", {1, 3}}}, {{"mesh", 0}}, {{"mesh", 0}}, lamp};
  Json& visibility = builder.json["nodes"][0]["extensions"]["KHR_node_visibility"];
  builder.json["scenes"][0]["nodes"] = {0, 2};
  builder.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  builder.json["extensionsUsed"] = {"KHR_node_visibility", "KHR_lights_punctual"};
  visibility["visible"] = true;
  EXPECT_EQ(read(builder).objects.size(), 2u);
  EXPECT_EQ(read(builder).lights.size(), 1u);
  visibility["visible"] = false;
  const scene::Scene scene = read(builder);
  ASSERT_EQ(scene.objects.size(), 1u);
  EXPECT_EQ(scene.objects[0].node, 2u);
  EXPECT_TRUE(scene.lights.empty());
  ASSERT_EQ(scene.skipped.size(), 2u);
  EXPECT_EQ(scene.skipped[0].node, 1u);
  EXPECT_EQ(scene.skipped[0].reason, "hidden");
  EXPECT_EQ(scene.skipped[1].node, 3u);
}

TEST(Skipped, MorphTargetsWidenTheBox) {
  SceneBuilder builder;
  builder.square();
  const std::size_t offsets =
      builder.accessor(std::vector<float>{0, 0, 0, 0, 0, 4, 0, 0, 0, -2, 0, 0}, "VEC3", 3);
  builder.primitive()["targets"] = {{{"POSITION", offsets}}};
  const scene::Scene scene = read(builder);
  EXPECT_TRUE(scene.objects.empty());
  ASSERT_EQ(scene.skipped.size(), 1u);
  EXPECT_EQ(scene.skipped[0].reason, "morph targets");
  ASSERT_EQ(scene.moving.size(), 1u);
  EXPECT_EQ(scene.moving[0].rest.lower, (Vec3d{-2, 0, 0}));
  EXPECT_EQ(scene.moving[0].rest.upper, (Vec3d{1, 1, 4}));
}

TEST(Skipped, SkinnedMeshesStandWhereTheirJointsStand) {
  SceneBuilder builder;
  skinned_square(builder);
  builder.json["skins"] = {{{"joints", {1, 2}}}};
  // The mesh node's own transform does not count (glTF 3.7.3.3).
  builder.json["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"translation", {1000, 0, 0}}},
                           {{"translation", {0, 0, 5}}, {"children", {2}}},
                           {{"translation", {0, 0, 1}}}};
  builder.json["scenes"][0]["nodes"] = {0, 1};
  const scene::Scene scene = read(builder);
  ASSERT_EQ(scene.skipped.size(), 1u);
  EXPECT_EQ(scene.skipped[0].reason, "skinned");
  ASSERT_EQ(scene.moving.size(), 1u);
  EXPECT_EQ(scene.moving[0].rest.lower, (Vec3d{0, 0, 5}));
  EXPECT_EQ(scene.moving[0].rest.upper, (Vec3d{1, 1, 6}));

  // Trees of the joints do not matter to where they stand.
  builder.json["nodes"][1].erase("children");
  builder.json["nodes"][2]["translation"] = {0, 0, 6};
  builder.json["scenes"][0]["nodes"] = {0, 1, 2};
  const auto forest = builder.read();
  ASSERT_TRUE(forest.ok());
  EXPECT_EQ(forest->warnings,
            std::vector<std::string>{"scene.glb#/skins/0: the joints have no common root"});
  EXPECT_EQ(read(builder).moving.at(0).rest.upper, (Vec3d{1, 1, 6}));

  builder.json["skins"][0]["joints"] = {1};
  const auto document = builder.read();
  ASSERT_TRUE(document.ok());
  EXPECT_EQ(read_scene(*document).status().reason(), "INPUT_MALFORMED");
}

}  // namespace
}  // namespace lightbatch::scene_in
