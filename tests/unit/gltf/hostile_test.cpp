#include "tests/unit/gltf/hostile_kit.h"

namespace lightbatch::gltf {
namespace {

TEST(Hostile, EachFaultIsNamed) {
  for (const Fault& fault : faults()) {
    SceneBuilder builder;
    builder.square();
    builder.json["buffers"] = Json::array({Json::object()});
    fault.make(builder.json);
    SceneFiles files;
    Json json = builder.json;
    const auto glb = write_glb(json, builder.binary);
    ASSERT_TRUE(glb.ok()) << fault.name;
    // write_glb() sets the length of buffer 0; faults of that length come as .gltf.
    if (json["buffers"][0].contains("byteLength")) {
      files.add("scene.glb", json.dump());
    } else {
      files.add("scene.glb", *glb);
    }
    const auto document = files.read("scene.glb");
    ASSERT_FALSE(document.ok()) << fault.name;
    EXPECT_EQ(document.status().reason(), fault.reason)
        << fault.name << ": " << document.status().to_string();
    EXPECT_NE(document.status().place().find(fault.place), std::string::npos)
        << fault.name << ": " << document.status().to_string();
    EXPECT_TRUE(document.status().place().starts_with("scene.glb")) << fault.name;
  }
}

TEST(Hostile, OddValuesAreSaid) {
  const auto warned = [](const std::function<void(Json&)>& change, const char* place) {
    SceneBuilder builder;
    builder.square();
    change(builder.json);
    const auto document = builder.read();
    if (!document.ok()) return document.status().to_string();
    for (const std::string& warning : document->warnings) {
      if (warning.find(place) != std::string::npos) return std::string("said");
    }
    return std::string("not a word");
  };
  EXPECT_EQ(warned([](Json& j) { j["nodes"][0]["rotation"] = {0, 0, 0, 2}; }, "rotation"), "said");
  EXPECT_EQ(warned(
                [](Json& j) {
                  j["nodes"][0]["matrix"] = {1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
                },
                "matrix"),
            "said");
  EXPECT_EQ(warned([](Json& j) { animate(j, "scale", "VEC3"); }, "ascend"), "said");
  EXPECT_EQ(warned([](Json& j) { j["bufferViews"][0]["target"] = 7; }, "target"), "said");
  EXPECT_EQ(warned([](Json& j) { j["accessors"][0].erase("min"); }, "min and max"), "said");
  EXPECT_EQ(warned([](Json& j) { j["meshes"][0]["primitives"][0]["attributes"]["SOMETHING"] = 0; },
                   "SOMETHING"),
            "said");
  EXPECT_EQ(warned([](Json& j) { j["images"] = {Json::object()}; }, "/images/0"), "said");
  EXPECT_EQ(warned([](Json& j) { j["accessors"][1]["count"] = 5; }, "5 corners"), "said");
  EXPECT_EQ(warned(
                [](Json& j) {
                  j["accessors"][1]["count"] = 2;
                  j["meshes"][0]["primitives"][0]["mode"] = 5;
                },
                "2 corners"),
            "said");
  EXPECT_EQ(warned([](Json& j) { j["meshes"][0]["primitives"][0]["mode"] = 6; }, "corners"),
            "not a word");
}

TEST(Hostile, BudgetsHold) {
  SceneBuilder builder;
  builder.square();
  EXPECT_EQ(builder.read({.json_bytes = 100}).status().reason(), kOverBudget);
  EXPECT_EQ(builder.read({.decoded_bytes = 100}).status().reason(), kOverBudget);
  EXPECT_EQ(builder.read({.nodes = 0}).status().reason(), kOverBudget);
  EXPECT_EQ(builder.read({.json_depth = 3}).status().reason(), kOverBudget);
}

TEST(Hostile, LenientWhereNothingIsHarmed) {
  SceneBuilder builder;
  builder.square();
  Json& json = builder.json;
  json["buffers"] = {Json::object(),
                     {{"byteLength", 1000}},
                     {{"byteLength", 5}, {"uri", "http://example.com/unused.bin"}}};
  json["accessors"].push_back({{"componentType", 5126}, {"count", 3}, {"type", "VEC7"}});
  json["extensionsUsed"] = {"ACME_something"};
  json["nodes"][0]["extras"] = {{"anything", {1, "x"}}};
  json["nodes"][0]["extensions"]["ACME_something"] = {{"kept", true}};
  json["cameras"] = {
      {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 2}, {"zfar", 1}}}}};
  const auto document = builder.read();
  ASSERT_TRUE(document.ok()) << document.status().to_string();
  EXPECT_EQ(document->warnings.size(), 3u);
  EXPECT_EQ(document->json["nodes"][0]["extras"]["anything"][1], "x");
  EXPECT_EQ(document->json["nodes"][0]["extensions"]["ACME_something"]["kept"], true);
}

TEST(Hostile, IntegersWrittenAsFloatsBecomeIntegers) {
  SceneBuilder builder;
  builder.square();
  builder.json["scene"] = 0.0;
  builder.json["accessors"][0]["count"] = 4.0;
  builder.primitive()["targets"] = {{{"POSITION", 0.0}}};
  const auto document = builder.read();
  ASSERT_TRUE(document.ok()) << document.status().to_string();
  EXPECT_TRUE(document->json["accessors"][0]["count"].is_number_integer());
  EXPECT_TRUE(
      document->json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"].is_number_integer());
}

TEST(Hostile, FilesBesideTheSceneAndDataUris) {
  SceneBuilder builder;
  builder.square();
  SceneFiles files;
  Json json = builder.json;
  json["buffers"] = {{{"byteLength", builder.binary.size()}, {"uri", "../data/a%20b.bin"}}};
  json["images"] = {{{"uri", "data:image/png;base64,Zm9v"}}, {{"uri", "x/picture.png"}}};
  json["textures"] = {{{"source", 0}}, {{"source", 1}}};
  files.add("models/scene.gltf", json.dump());
  files.add("data/a b.bin", builder.binary);
  files.add("models/x/picture.png", "picture");
  const auto document = files.read("models/scene.gltf");
  ASSERT_TRUE(document.ok()) << document.status().to_string();
  EXPECT_EQ(document->buffers[0], builder.binary);
  EXPECT_EQ(as_text(document->images[0]), "foo");
  EXPECT_EQ(as_text(document->images[1]), "picture");
  EXPECT_EQ(document->input_bytes, json.dump().size() + builder.binary.size() + 7);
}

TEST(Hostile, DeepNodeChainsNeedNoStack) {
  SceneBuilder builder;
  builder.square();
  constexpr int kDepth = 200'000;
  Json nodes = Json::array();
  for (int i = 0; i < kDepth; ++i) nodes.push_back({{"children", {i + 1}}});
  nodes.push_back({{"mesh", 0}});
  builder.json["nodes"] = std::move(nodes);
  EXPECT_TRUE(builder.read().ok());
}

}  // namespace
}  // namespace lightbatch::gltf
