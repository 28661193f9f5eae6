#include "core/scene_out/relit_scene.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/gltf/glb_container.h"
#include "core/gltf/glb_writer.h"

namespace lightbatch::scene_out {
namespace {

using Json = nlohmann::json;

Bytes filled(std::size_t size, int value) { return Bytes(size, static_cast<std::byte>(value)); }

/// A page of 10 bytes between two runs of geometry, a light taken out, a light left in.
Bytes scene() {
  Bytes binary;
  for (const Bytes& part : {filled(32, 1), filled(10, 2), filled(6, 0), filled(32, 3)}) {
    binary.insert(binary.end(), part.begin(), part.end());
  }
  Json json = Json::parse(R"({
    "asset": {"version": "2.0"}, "buffers": [{"byteLength": 80}],
    "bufferViews": [{"buffer": 0, "byteLength": 32},
                    {"buffer": 0, "byteOffset": 48, "byteLength": 32},
                    {"buffer": 0, "byteOffset": 32, "byteLength": 10}],
    "images": [{"name": "lightmap_0", "uri": "of_the_input.png"},
               {"name": "lightmap_0", "bufferView": 2, "mimeType": "image/png"}],
    "textures": [{"source": 1}],
    "materials": [
      {"emissiveFactor": [1, 1, 1]},
      {"name": "wall", "extensions": {"MOZ_lightmap": {"index": 0, "texCoord": 1, "intensity": 9}}},
      {"emissiveFactor": [1, 1, 1]},
      {"emissiveFactor": [1, 1, 1]}],
    "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 5}]}},
    "scenes": [{"extras": {"lightbatch": {"page_images": [1], "emitters": {"0": [2]}, "lights": [
      {"node": 3, "index": 0, "light": {"type": "point", "intensity": 5}}]}}}]})");
  return *gltf::write_glb(json, binary);
}

struct File {
  Json json;
  Bytes binary;
  explicit File(const Bytes& glb) {
    const auto chunks = gltf::split_glb(glb, "out.glb");
    json = Json::parse(chunks->json);
    binary.assign(chunks->binary->begin(), chunks->binary->end());
  }
  Bytes view(std::size_t i) const {
    const Json& v = json["bufferViews"][i];
    const auto at = binary.begin() + v.value("byteOffset", 0);
    return {at, at + v["byteLength"].get<int>()};
  }
};

TEST(RelitScene, PagesOfAnySizeMoveWhatFollowsByWholeAlignments) {
  for (const std::size_t size : {1u, 9u, 10u, 11u, 100u}) {
    const RelitPage page{filled(size, 7), 2.5f};
    const auto out = relit_scene(scene(), "in.glb", std::span(&page, 1), {}, {});
    ASSERT_TRUE(out.ok()) << out.status().to_string();
    const File file(*out);
    EXPECT_EQ(file.view(0), filled(32, 1));
    EXPECT_EQ(file.view(1), filled(32, 3)) << size;
    EXPECT_EQ(file.view(2), filled(size, 7));
    EXPECT_EQ(file.json["bufferViews"][1]["byteOffset"].get<int>() % 16, 0);
    EXPECT_EQ(file.json["materials"][1]["extensions"]["MOZ_lightmap"]["intensity"], 2.5);
  }
}

TEST(RelitScene, LightsAndTheMaterialWithItsClonesChange) {
  const RelitPage page{filled(10, 7), 1};
  const RelitLight light{0, {1, 0.5, 0}, 70};
  const RelitMaterial material{0, {1, 0, 1}, 12};
  const auto out =
      relit_scene(scene(), "in.glb", std::span(&page, 1), std::span(&light, 1), {&material, 1});
  ASSERT_TRUE(out.ok()) << out.status().to_string();
  const Json json = File(*out).json;
  EXPECT_EQ(json["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"], 70);
  const Json& taken = json["scenes"][0]["extras"]["lightbatch"]["lights"][0]["light"];
  EXPECT_EQ(taken["color"], Json({1, 0.5, 0}));
  for (const std::size_t i : {0u, 2u}) {
    const Json& lamp = json["materials"][i];
    EXPECT_EQ(lamp["emissiveFactor"], Json({1, 0, 1}));
    EXPECT_EQ(lamp["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"], 12);
  }
  EXPECT_EQ(json["materials"][3]["emissiveFactor"], Json({1, 1, 1}));
}

TEST(RelitScene, RefusesWhatIsNoSuchScene) {
  const std::vector<RelitPage> two(2, {filled(10, 7), 1});
  EXPECT_FALSE(relit_scene(scene(), "in.glb", two, {}, {}).ok());
  EXPECT_FALSE(relit_scene(filled(40, 1), "in.glb", std::span(two).first(1), {}, {}).ok());
  File file(scene());
  file.json["bufferViews"][2]["byteLength"] = 1000;
  const Bytes outside = *gltf::write_glb(file.json, file.binary);
  EXPECT_FALSE(relit_scene(outside, "in.glb", std::span(two).first(1), {}, {}).ok());
}

TEST(RelitScene, HostileNumbersDoNoHarm) {
  const RelitPage page{filled(10, 7), 1};
  const RelitMaterial material{0, {1, 0, 1}, 12};
  const auto relit = [&](const char* key, const Json& value) {
    File file(scene());
    file.json["scenes"][0]["extras"]["lightbatch"][key] = value;
    return relit_scene(*gltf::write_glb(file.json, file.binary), "in.glb", {&page, 1}, {},
                       {&material, 1})
        .status();
  };
  for (const Json& images : {Json(5), Json("1"), Json::array(), Json({0}), Json({7}), Json({-1}),
                             Json({1e30}), Json({1, 1}), Json({nullptr})}) {
    EXPECT_EQ(relit("page_images", images).reason(), "INPUT_MALFORMED") << images;
  }
  for (const Json& clones : {Json(5), Json({{"0", 3}}), Json({{"0", {-1, 99, "x", nullptr}}})}) {
    EXPECT_TRUE(relit("emitters", clones).ok()) << clones;
  }
}

}  // namespace
}  // namespace lightbatch::scene_out
