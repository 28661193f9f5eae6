#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/scene_out/files.h"

namespace lightbatch::scene_out {
namespace {

using testing::FileBuilder;
using testing::Json;
using testing::load;
using testing::Loaded;
using testing::write;

Json written(const FileBuilder& file, bool with_batches = true, bool lit = false,
             WriteOptions options = {}) {
  const Loaded in = load(file.glb());
  atlas::Layout layout;
  if (lit) layout = testing::simple_layout(in.scene);
  return testing::read(write(in, with_batches, lit ? &layout : nullptr, {}, options).glb).json;
}

const Json* named(const Json& json, const std::string& name) {
  for (const Json& node : json["nodes"])
    if (node.value("name", "") == name) return &node;
  return nullptr;
}

TEST(Keep, AnimatedNodesStayAndKeysToo) {
  FileBuilder file;
  const std::uint32_t mesh = file.mesh({file.cube()});
  const std::uint32_t moving = file.node({{"mesh", mesh}, {"name", "door"}});
  file.node({{"mesh", file.mesh({file.cube()})}, {"name", "wall"}});
  file.animate(moving, {0, 0, 0, 1, 0, 0, 2, 0, 0});
  file.json["animations"][0]["name"] = "open";
  const Json out = written(file);
  ASSERT_EQ(out["animations"].size(), 1u);
  const Json& sampler = out["animations"][0]["samplers"][0];
  EXPECT_EQ(out["accessors"][sampler["input"].get<std::size_t>()]["count"], 3);
  EXPECT_EQ(out["accessors"][sampler["output"].get<std::size_t>()]["type"], "VEC3");
  const Json& target =
      out["nodes"][out["animations"][0]["channels"][0]["target"]["node"].get<std::size_t>()];
  EXPECT_EQ(target["name"], "door");
  EXPECT_TRUE(target.contains("mesh"));
  EXPECT_FALSE(named(out, "wall")->contains("mesh"));
}

TEST(Keep, NamesExtrasCamerasAndUnknownExtensions) {
  FileBuilder file;
  Json node{{"mesh", file.mesh({file.cube()})}, {"name", "crate"}, {"extras", {{"id", 7}}}};
  node["extensions"]["VENDOR_physics"] = {{"weight", 2.5}};
  file.json["meshes"][0]["extras"] = {{"sku", "a-1"}};
  file.json["meshes"][0]["name"] = "crate mesh";
  file.node(node);
  file.json["cameras"] = {
      {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}}};
  file.node({{"camera", 0}, {"name", "view"}});
  file.node({{"mesh", file.mesh({file.cube()})}, {"name", "plain"}});
  file.json["meshes"][1]["extras"] = {{"sku", "b-2"}};
  file.json["extensionsUsed"] = {"VENDOR_physics"};
  file.json["extras"] = {{"project", "x"}};
  file.json["asset"]["copyright"] = "someone";
  const Json out = written(file);
  EXPECT_EQ(out["asset"], file.json["asset"]);
  EXPECT_EQ(out["extras"], file.json["extras"]);
  EXPECT_EQ(out["cameras"], file.json["cameras"]);
  // A node extension that is not understood pins the object to its node.
  const Json* crate = named(out, "crate");
  ASSERT_NE(crate, nullptr);
  EXPECT_EQ((*crate)["extras"], node["extras"]);
  EXPECT_EQ((*crate)["extensions"], node["extensions"]);
  ASSERT_TRUE(crate->contains("mesh"));
  EXPECT_EQ(out["meshes"][(*crate)["mesh"].get<std::size_t>()]["extras"]["sku"], "a-1");
  // A mesh that went into a batch leaves its extras with the range.
  EXPECT_FALSE(named(out, "plain")->contains("mesh"));
  const Json* batch = named(out, "batch_0");
  ASSERT_NE(batch, nullptr);
  EXPECT_EQ((*batch)["extras"]["lightbatch"]["ranges"][0]["mesh_extras"]["sku"], "b-2");
}

TEST(Keep, WhatPhysicsMoveOrPointersNameStays) {
  FileBuilder file;
  const auto body = [](Json value) { return Json{{"OMI_physics_body", std::move(value)}}; };
  const auto add = [&](const char* name, Json extensions) {
    Json node{{"mesh", file.mesh({file.cube()})}, {"name", name}};
    if (!extensions.is_null()) node["extensions"] = std::move(extensions);
    return file.node(std::move(node));
  };
  add("crate", body({{"motion", {{"type", "dynamic"}}}}));
  add("lift", body({{"type", "kinematic"}}));
  add("floor", body({{"motion", {{"type", "static"}}}}));
  add("wall", body({{"collider", {{"shape", 0}}}}));
  const std::uint32_t door = add("door", nullptr);
  add("roof", nullptr);
  file.json["extensions"]["KHR_interactivity"]["pointer"] =
      "/nodes/" + std::to_string(door) + "/rotation";
  file.json["extensionsUsed"] = {"KHR_interactivity", "OMI_physics_body"};
  Json out = written(file);
  for (const char* name : {"crate", "lift", "door"})
    EXPECT_TRUE(named(out, name)->contains("mesh")) << name;
  for (const char* name : {"floor", "wall", "roof"})
    EXPECT_FALSE(named(out, name)->contains("mesh")) << name;

  // A node that is chosen while the scene runs may be any.
  file.json["extensions"]["KHR_interactivity"]["pointer"] = "/nodes/{index}/rotation";
  out = written(file);
  EXPECT_TRUE(named(out, "roof")->contains("mesh"));
}

TEST(Keep, WhatHangsOnJointsStays) {
  FileBuilder file;
  file.node({{"mesh", file.mesh({file.cube()})}, {"name", "wall"}});
  const std::uint32_t hat = file.node({{"mesh", file.mesh({file.cube()})}, {"name", "hat"}});
  file.json["scenes"][0]["nodes"].erase(1);
  const std::uint32_t head = file.node({{"name", "head"}, {"children", {hat}}});
  file.json["skins"] = {{{"joints", {head}}}};
  const Json out = written(file);
  EXPECT_TRUE(named(out, "hat")->contains("mesh"));
  EXPECT_FALSE(named(out, "wall")->contains("mesh"));
}

TEST(Keep, SkinsOfJointsWithoutACommonRootStayAsTheyWere) {
  FileBuilder file;
  file.node({{"mesh", file.mesh({file.cube()})}, {"name", "wall"}});
  Json skinned = file.cube();
  std::vector<std::uint8_t> joints;
  std::vector<float> weights;
  for (std::uint8_t v = 0; v < 24; ++v) {
    joints.insert(joints.end(), {static_cast<std::uint8_t>(v % 2), 0, 0, 0});
    weights.insert(weights.end(), {1, 0, 0, 0});
  }
  skinned["attributes"]["JOINTS_0"] = file.accessor(joints, 5121, "VEC4");
  skinned["attributes"]["WEIGHTS_0"] = file.accessor(weights, 5126, "VEC4");
  const std::uint32_t left = file.node({{"name", "left"}, {"translation", {1, 0, 0}}});
  const std::uint32_t right = file.node({{"name", "right"}, {"translation", {0, 2, 0}}});
  const std::uint32_t body =
      file.node({{"mesh", file.mesh({skinned})}, {"skin", 0}, {"name", "body"}});
  file.json["skins"] = {{{"joints", {left, right}}, {"name", "both"}}};
  file.animate(right, {0, 2, 0, 0, 3, 0});
  const Json out = written(file);
  EXPECT_EQ(out["skins"], file.json["skins"]);
  for (const std::uint32_t node : {left, right}) {
    EXPECT_EQ(out["nodes"][node], file.json["nodes"][node]);
    const Json& roots = out["scenes"][0]["nodes"];
    EXPECT_NE(std::find(roots.begin(), roots.end(), node), roots.end());
  }
  EXPECT_EQ(out["nodes"][body]["skin"], 0);
  EXPECT_TRUE(out["nodes"][body].contains("mesh"));
  EXPECT_EQ(out["animations"][0]["channels"][0]["target"]["node"], right);
  EXPECT_FALSE(named(out, "wall")->contains("mesh"));
}

TEST(Keep, ObjectsWithAVariantThatIsSeenThroughAreKnown) {
  FileBuilder file;
  file.json["materials"] = {
      {{"name", "plaster"}},
      {{"name", "paint"}},
      {{"name", "net"}, {"alphaMode", "MASK"}},
      {{"name", "sheet"}, {"doubleSided", true}},
      {{"name", "glass"}, {"extensions", {{"KHR_materials_transmission", Json::object()}}}}};
  file.json["extensionsUsed"] = {"KHR_materials_variants", "KHR_materials_transmission"};
  file.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "other"}}};
  for (int other = 0; other < 5; ++other) {
    Json wall = file.cube();
    wall["material"] = 0;
    if (other > 0)
      wall["extensions"]["KHR_materials_variants"]["mappings"] = {
          {{"material", other}, {"variants", {0}}}};
    file.node({{"mesh", file.mesh({wall})}});
  }
  const Loaded in = load(file.glb());
  EXPECT_EQ(opening_objects(in.document, in.scene),
            (std::vector<bool>{false, false, true, true, true}));
}

TEST(Keep, OtherScenesKeepTheirNodes) {
  FileBuilder file;
  const std::uint32_t both = file.node({{"mesh", file.mesh({file.cube()})}, {"name", "both"}});
  file.node({{"mesh", file.mesh({file.cube()})}, {"name", "one"}});
  file.json["scenes"].push_back({{"nodes", {both}}, {"name", "second"}});
  const Json out = written(file);
  ASSERT_EQ(out["scenes"].size(), 2u);
  EXPECT_EQ(out["scenes"][1], file.json["scenes"][1]);
  EXPECT_TRUE(named(out, "both")->contains("mesh"));
  EXPECT_FALSE(named(out, "one")->contains("mesh"));
}

TEST(Keep, LinesStayAndAreNeverInstanced) {
  FileBuilder file;
  Json lines = file.cube();
  lines["mode"] = 1;
  const std::uint32_t mesh = file.mesh({file.cube(), lines});
  for (int i = 0; i < 60; ++i) file.node({{"mesh", mesh}, {"translation", {30 * i, 0, 0}}});
  const Json out = written(file);
  std::size_t line_nodes = 0, instanced = 0;
  for (const Json& node : out["nodes"]) {
    if (!node.contains("mesh")) continue;
    const bool cell =
        node.contains("extensions") && node["extensions"].contains("EXT_mesh_gpu_instancing");
    instanced += cell ? 1 : 0;
    for (const Json& p : out["meshes"][node["mesh"].get<std::size_t>()]["primitives"])
      if (p.value("mode", 4) == 1) {
        ++line_nodes;
        EXPECT_FALSE(cell);
      }
  }
  EXPECT_EQ(line_nodes, 60u);
  EXPECT_GT(instanced, 0u);
  EXPECT_EQ(out["extensionsRequired"], Json::array({"EXT_mesh_gpu_instancing"}));
}

TEST(Keep, VariantsKeepTheirMappings) {
  FileBuilder file;
  file.json["materials"] = {{{"name", "red"}}, {{"name", "blue"}}};
  Json cube = file.cube();
  cube["material"] = 0;
  cube["extensions"]["KHR_materials_variants"]["mappings"] = {{{"material", 1}, {"variants", {0}}}};
  file.node({{"mesh", file.mesh({cube})}, {"name", "sofa"}});
  file.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "night"}}};
  file.json["extensionsUsed"] = {"KHR_materials_variants"};
  for (const bool lit : {false, true}) {
    const Json out = written(file, true, lit);
    ASSERT_NE(named(out, "sofa"), nullptr);
    ASSERT_EQ(out["meshes"].size(), 1u);
    const Json& p = out["meshes"][0]["primitives"][0];
    const Json& mapping = p["extensions"]["KHR_materials_variants"]["mappings"][0];
    EXPECT_EQ(mapping["variants"], Json::array({0}));
    const Json& variant = out["materials"][mapping["material"].get<std::size_t>()];
    EXPECT_EQ(variant["name"], "blue");
    EXPECT_EQ(variant.contains("extensions"), lit);
  }
}

TEST(Keep, AnimatedMaterialsChangeWithTheirClones) {
  FileBuilder file;
  file.json["materials"] = {{{"name", "still"}}, {{"name", "sign"}}};
  Json cube = file.cube();
  cube["material"] = 1;
  file.node({{"mesh", file.mesh({cube})}, {"name", "static"}});
  Json morphing = cube;
  morphing["targets"] = {{{"POSITION", cube["attributes"]["POSITION"]}}};
  file.node({{"mesh", file.mesh({morphing})}, {"name", "morphs"}});
  const std::uint32_t times = file.accessor(std::vector<float>{0, 1}, 5126, "SCALAR");
  file.json["accessors"][times].update(Json{{"min", {0}}, {"max", {1}}});
  const std::uint32_t values = file.accessor(std::vector<float>{0, 0, 0, 1, 1, 1}, 5126, "VEC3");
  Json channel{{"sampler", 0}, {"target", {{"path", "pointer"}}}};
  Json& pointer = channel["target"]["extensions"]["KHR_animation_pointer"]["pointer"];
  pointer = "/materials/1/emissiveFactor";
  file.json["animations"] = {
      {{"channels", {channel}}, {"samplers", {{{"input", times}, {"output", values}}}}}};
  file.json["extensionsUsed"] = {"KHR_animation_pointer"};
  EXPECT_EQ(written(file)["animations"][0]["channels"], Json::array({channel}));
  const Json out = written(file, true, true);
  std::size_t clone = 0;
  for (std::size_t m = 2; m < out["materials"].size(); ++m)
    if (out["materials"][m]["name"] == "sign") clone = m;
  ASSERT_GT(clone, 0u);
  Json second = channel;
  second["target"]["extensions"]["KHR_animation_pointer"]["pointer"] =
      "/materials/" + std::to_string(clone) + "/emissiveFactor";
  EXPECT_EQ(out["animations"][0]["channels"], Json::array({channel, second}));
}

TEST(Keep, UnlitVariantsGetNoLightmap) {
  FileBuilder file;
  Json unlit{{"name", "screen"}};
  unlit["extensions"]["KHR_materials_unlit"] = Json::object();
  file.json["materials"] = {{{"name", "red"}}, unlit};
  Json cube = file.cube();
  cube["material"] = 0;
  cube["extensions"]["KHR_materials_variants"]["mappings"] = {{{"material", 1}, {"variants", {0}}}};
  file.node({{"mesh", file.mesh({cube})}});
  file.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "on"}}};
  file.json["extensionsUsed"] = {"KHR_materials_variants", "KHR_materials_unlit"};
  for (const bool batches : {false, true}) {
    const Json out = written(file, batches, true);
    const Json& p = out["meshes"][0]["primitives"][0];
    const Json& mapping = p["extensions"]["KHR_materials_variants"]["mappings"][0];
    EXPECT_EQ(out["materials"][mapping["material"].get<std::size_t>()], unlit);
    const Json& own = out["materials"][p["material"].get<std::size_t>()];
    EXPECT_TRUE(own["extensions"].contains("MOZ_lightmap"));
  }
}

TEST(Keep, ExtensionsOfMeshes) {
  FileBuilder file;
  const std::uint32_t tagged = file.mesh({file.cube()});
  file.json["meshes"][tagged]["extensions"]["VENDOR_tag"]["sku"] = "a-1";
  file.json["extensionsUsed"] = {"VENDOR_tag"};
  file.node({{"mesh", tagged}, {"name", "crate"}});
  file.node({{"mesh", file.mesh({file.cube()})}, {"name", "wall"}});
  for (const bool lit : {false, true}) {
    const Json out = written(file, true, lit);
    ASSERT_TRUE(named(out, "crate")->contains("mesh"));
    const Json& mesh = out["meshes"][(*named(out, "crate"))["mesh"].get<std::size_t>()];
    EXPECT_EQ(mesh["extensions"], file.json["meshes"][tagged]["extensions"]);
    EXPECT_FALSE(named(out, "wall")->contains("mesh"));
  }
}

TEST(Keep, ThicknessIsOfTheMesh) {
  FileBuilder file;
  Json glass;
  glass["extensions"]["KHR_materials_volume"]["thicknessFactor"] = 0.1;
  file.json["materials"] = {glass};
  file.json["extensionsUsed"] = {"KHR_materials_volume"};
  Json cube = file.cube();
  cube["material"] = 0;
  file.node({{"mesh", file.mesh({cube})}, {"name", "as made"}, {"rotation", {0, 1, 0, 0}}});
  file.node({{"mesh", file.mesh({cube})}, {"name", "large"}, {"scale", {3, 3, 3}}});
  const Json out = written(file);
  EXPECT_FALSE(named(out, "as made")->contains("mesh"));
  EXPECT_TRUE(named(out, "large")->contains("mesh"));
}

TEST(Keep, PicturesOfAnyFormatComeIntoTheFile) {
  FileBuilder file;
  file.node({{"mesh", file.mesh({file.cube()})}});
  file.json["images"] = {{{"uri", "wood.AVIF"}}, {{"uri", "old.dds"}}};
  file.json["buffers"][0].update(Json{{"name", "all"}, {"extras", {{"made", 1999}}}});
  const auto folder = std::filesystem::temp_directory_path();
  const auto glb = folder / ("keep_test_" + std::to_string(getpid()) + ".glb");
  const auto picture = folder / ("keep_test_" + std::to_string(getpid()) + ".picture");
  const Bytes bytes(7, std::byte{42});
  ASSERT_TRUE(write_file(glb, file.glb()).ok() && write_file(picture, bytes).ok());
  Loaded in;
  in.document = *gltf::read_document(
      {{"test.glb", glb}, {"wood.AVIF", picture}, {"old.dds", picture}}, "test.glb");
  in.scene = *scene_in::read_scene(in.document);
  const auto out = testing::read(write(in, true).glb);
  std::filesystem::remove(glb);
  std::filesystem::remove(picture);
  EXPECT_EQ(out.json["images"][0]["mimeType"], "image/avif");
  EXPECT_EQ(out.json["images"][1]["mimeType"], "image/vnd-ms.dds");
  for (const Json& image : out.json["images"]) EXPECT_FALSE(image.contains("uri"));
  ASSERT_EQ(out.images.size(), 2u);
  EXPECT_EQ(out.images[0], bytes);
  EXPECT_EQ(out.images[1], bytes);
  EXPECT_EQ(out.json["buffers"][0]["name"], "all");
  EXPECT_EQ(out.json["buffers"][0]["extras"], (Json{{"made", 1999}}));
}

FileBuilder lamp_file() {
  FileBuilder file;
  file.node({{"mesh", file.mesh({file.cube()})}});
  file.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"intensity", 40}, {"name", "bulb"}}};
  file.json["extensionsUsed"] = {"KHR_lights_punctual"};
  Json lamp{{"name", "lamp"}, {"translation", {0, 3, 0}}};
  lamp["extensions"]["KHR_lights_punctual"]["light"] = 0;
  file.node(lamp);
  return file;
}

TEST(Keep, BakedLightsGoIntoExtras) {
  const Json out = written(lamp_file(), true, true);
  EXPECT_FALSE(out.contains("extensions"));
  EXPECT_EQ(out["extensionsUsed"], Json::array({"MOZ_lightmap"}));
  EXPECT_FALSE(named(out, "lamp")->contains("extensions"));
  const Json& lights = out["scenes"][0]["extras"]["lightbatch"]["lights"];
  ASSERT_EQ(lights.size(), 1u);
  EXPECT_EQ(lights[0]["light"]["name"], "bulb");
  EXPECT_EQ(lights[0]["node"], 1);
}

TEST(Keep, LightsStayWhenAskedOrWhenNothingIsBaked) {
  WriteOptions keep;
  keep.remove_lights = false;
  for (const Json& out :
       {written(lamp_file(), true, true, keep), written(lamp_file(), true, false)}) {
    EXPECT_TRUE(out["extensions"].contains("KHR_lights_punctual"));
    EXPECT_TRUE(named(out, "lamp")->contains("extensions"));
  }
}

TEST(Keep, WithoutBatchesAndLightNothingChanges) {
  FileBuilder file = lamp_file();
  const Json out = written(file, false);
  EXPECT_EQ(out["nodes"], file.json["nodes"]);
  EXPECT_EQ(out["meshes"], file.json["meshes"]);
}

TEST(Keep, EmptySceneAndNoScene) {
  FileBuilder file;
  file.json.erase("meshes");
  file.json.erase("accessors");
  file.json.erase("bufferViews");
  file.json.erase("buffers");
  file.json["nodes"] = {{{"name", "alone"}}};
  file.json["scenes"][0]["nodes"] = {0};
  EXPECT_NE(named(written(file), "alone"), nullptr);
  file.json.erase("scenes");
  file.json.erase("scene");
  EXPECT_NE(named(written(file), "alone"), nullptr);
}

}  // namespace
}  // namespace lightbatch::scene_out
