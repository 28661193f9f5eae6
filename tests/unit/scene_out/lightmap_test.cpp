#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>

#include "core/gltf/accessor.h"
#include "tests/unit/scene_out/files.h"

namespace lightbatch::scene_out {
namespace {

using testing::FileBuilder;
using testing::Json;
using testing::load;
using testing::Loaded;
using testing::write;

FileBuilder boxes(int n, bool share) {
  FileBuilder file;
  file.json["materials"] = {{{"name", "paint"}, {"extras", {{"id", 3}}}}};
  std::uint32_t mesh = 0;
  for (int i = 0; i < n; ++i) {
    Json cube = file.cube();
    cube["material"] = 0;
    if (i == 0 || !share) mesh = file.mesh({cube});
    file.node({{"mesh", mesh}, {"name", "box"}, {"translation", {2 * i, 0, 0}}});
  }
  return file;
}

/// The light that the file gives at each triangle's corners: world position -> (page, uv), and that
/// must be what the layout says.
void expect_light(const Loaded& in, const atlas::Layout& layout, const Bytes& glb) {
  const gltf::Document out = testing::read(glb);
  using Key = std::tuple<std::string, float, float, int, int, int>;
  std::multiset<Key> want, got;
  const auto key = [](const std::string& image, float u, float v, const Vec3d& p) {
    const auto grid = [](double x) { return static_cast<int>(std::lround(x * 1000)); };
    return Key{image, u, v, grid(p.x), grid(p.y), grid(p.z)};
  };
  for (std::uint32_t t = 0; t < in.scene.triangles.size(); ++t) {
    const auto corners = in.scene.corners(t);
    const std::uint32_t page = layout.charts[layout.chart_of[t]].page;
    for (std::size_t c = 0; c < 3; ++c)
      want.insert(key("lightmap_" + std::to_string(page),
                      layout.uv[t][c].x / static_cast<float>(layout.pages[page].width),
                      layout.uv[t][c].y / static_cast<float>(layout.pages[page].height),
                      in.scene.origin + to_double(corners[c])));
  }
  auto again = scene_in::read_scene(out);
  ASSERT_TRUE(again.ok());
  std::map<std::pair<std::uint32_t, std::uint32_t>, gltf::Values> uvs;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> indices;
  for (const scene::Triangle& t : again->triangles) {
    const scene::Object& o = again->objects[t.object];
    const Json& p = out.json["meshes"][o.mesh]["primitives"][o.primitive];
    const std::pair id{o.mesh, o.primitive};
    if (!uvs.contains(id)) {
      uvs[id] = *gltf::read_values(out, p["attributes"]["TEXCOORD_1"]);
      indices[id] = *gltf::read_indices(out, p["indices"]);
    }
    const Json& light =
        out.json["materials"][p["material"].get<std::size_t>()]["extensions"]["MOZ_lightmap"];
    EXPECT_EQ(light["texCoord"], 1);
    const Json& texture = out.json["textures"][light["index"].get<std::size_t>()];
    const Json& image = out.json["images"][texture["source"].get<std::size_t>()];
    const auto name = image["name"].get<std::string>();
    EXPECT_EQ(light["intensity"].get<float>(), 2.5f + static_cast<float>(name.back() - '0'));
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t at = o.mirrored && c != 0 ? 3 - c : c;
      const std::uint32_t v = indices[id][3 * t.source + at];
      got.insert(key(name, uvs[id].data[2 * v], uvs[id].data[2 * v + 1],
                     again->origin + to_double(again->positions[t.vertex[c]])));
    }
  }
  EXPECT_EQ(want, got);
}

class Lightmap : public ::testing::TestWithParam<std::tuple<bool, bool, int, bool>> {};

TEST_P(Lightmap, EveryCornerHasItsTexel) {
  const auto [batches, share, pages, mirror] = GetParam();
  FileBuilder file = boxes(5, share);
  if (mirror)
    for (Json& node : file.json["nodes"]) node["scale"] = {1, -1, 1};
  const Loaded in = load(file.glb());
  ASSERT_EQ(in.scene.triangles.size(), 60u);
  const atlas::Layout layout = testing::simple_layout(in.scene, pages);
  batches::BatchOptions options;
  expect_light(in, layout, write(in, batches, &layout, options).glb);
}

INSTANTIATE_TEST_SUITE_P(Ways, Lightmap,
                         ::testing::Combine(::testing::Bool(), ::testing::Bool(),
                                            ::testing::Values(1, 3), ::testing::Bool()));

TEST(LightmapFile, SamplersAndLists) {
  const Loaded in = load(boxes(2, false).glb());
  const atlas::Layout layout = testing::simple_layout(in.scene, 2);
  const Json out = testing::read(write(in, true, &layout).glb).json;
  EXPECT_EQ(out["extensionsUsed"], Json::array({"MOZ_lightmap"}));
  EXPECT_FALSE(out.contains("extensionsRequired"));
  EXPECT_EQ(out["images"].size(), 2u);
  EXPECT_EQ(out["images"][1]["name"], "lightmap_1");
  EXPECT_EQ(out["samplers"][0],
            (Json{{"magFilter", 9729}, {"minFilter", 9729}, {"wrapS", 33071}, {"wrapT", 33071}}));
  // One clone per page; the first took the place of the original.
  ASSERT_EQ(out["materials"].size(), 2u);
  for (const Json& m : out["materials"]) {
    EXPECT_EQ(m["name"], "paint");
    EXPECT_EQ(m["extras"]["id"], 3);
  }
}

TEST(LightmapFile, SharedMeshesShareAllButTheLight) {
  const Loaded in = load(boxes(4, true).glb());
  const atlas::Layout layout = testing::simple_layout(in.scene);
  const Json out = testing::read(write(in, false, &layout).glb).json;
  ASSERT_EQ(out["meshes"].size(), 4u);
  std::set<std::size_t> positions, uvs, indices;
  for (const Json& mesh : out["meshes"]) {
    const Json& p = mesh["primitives"][0];
    positions.insert(p["attributes"]["POSITION"].get<std::size_t>());
    uvs.insert(p["attributes"]["TEXCOORD_1"].get<std::size_t>());
    indices.insert(p["indices"].get<std::size_t>());
  }
  EXPECT_EQ(positions.size(), 1u);
  EXPECT_EQ(indices.size(), 1u);
  EXPECT_EQ(uvs.size(), 4u);
}

TEST(LightmapFile, TexturesOnSetOneMoveAway) {
  for (const bool batches : {true, false}) {
    FileBuilder file = boxes(2, false);
    file.json["images"] = {{{"uri", "data:image/png;base64,iVBORw0KGgo="}}};
    file.json["textures"] = {{{"source", 0}}};
    file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0},
                                                                             {"texCoord", 0}};
    Json ao{{"index", 0}, {"texCoord", 0}};
    ao["extensions"]["KHR_texture_transform"] = {{"offset", {0.5, 0}}, {"texCoord", 1}};
    file.json["materials"][0]["occlusionTexture"] = ao;
    file.json["extensionsUsed"] = {"KHR_texture_transform"};
    for (Json& mesh : file.json["meshes"]) {
      Json& attributes = mesh["primitives"][0]["attributes"];
      attributes["TEXCOORD_1"] = attributes["TEXCOORD_0"];
    }
    const Loaded in = load(file.glb());
    const atlas::Layout layout = testing::simple_layout(in.scene);
    const gltf::Document out = testing::read(write(in, batches, &layout).glb);
    const Json& p = out.json["meshes"][0]["primitives"][0];
    const Json& material = out.json["materials"][p["material"].get<std::size_t>()];
    EXPECT_EQ(material["occlusionTexture"]["extensions"]["KHR_texture_transform"]["texCoord"], 2);
    EXPECT_EQ(material["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"], 0);
    const auto zero = *gltf::read_values(out, p["attributes"]["TEXCOORD_0"]);
    const auto two = *gltf::read_values(out, p["attributes"]["TEXCOORD_2"]);
    EXPECT_EQ(zero.data, two.data);
  }
}

TEST(LightmapFile, UnlitTrianglesKeepTheirMaterial) {
  const Loaded in = load(boxes(3, false).glb());
  atlas::Layout layout = testing::simple_layout(in.scene);
  for (std::uint32_t t = 12; t < 24; ++t) layout.chart_of[t] = scene::kNone;
  const Json out = testing::read(write(in, true, &layout).glb).json;
  std::map<bool, int> primitives;
  for (const Json& mesh : out["meshes"])
    for (const Json& p : mesh["primitives"]) {
      const Json& m = out["materials"][p["material"].get<std::size_t>()];
      const bool lit = m.contains("extensions");
      ++primitives[lit];
      EXPECT_EQ(p["attributes"].contains("TEXCOORD_1"), lit);
    }
  EXPECT_EQ(primitives[true], 1);
  EXPECT_EQ(primitives[false], 1);
}

/// Unnamed lamps that differ in their base colour alone, on two pages: a relight finds each.
TEST(LightmapFile, ClonesOfEmittersAreListed) {
  FileBuilder file;
  file.json["images"] = {{{"name", "lightmap_0"}, {"uri", "data:image/png;base64,iVBORw0KGgo="}}};
  file.json["materials"] = Json::array();
  for (const double red : {0.25, 0.5}) {
    file.json["materials"].push_back(
        {{"emissiveFactor", {1, 1, 1}},
         {"pbrMetallicRoughness", {{"baseColorFactor", {red, 1, 1, 1}}}}});
  }
  for (int i = 0; i < 8; ++i) {
    Json cube = file.cube();
    cube["material"] = i / 2 % 2;
    file.node({{"mesh", file.mesh({cube})}, {"translation", {2 * i, 0, 0}}});
  }
  const Loaded in = load(file.glb());
  const atlas::Layout layout = testing::simple_layout(in.scene, 2);
  for (const bool batches : {true, false}) {
    const gltf::Document out =
        testing::read(write(in, batches, &layout, batches::BatchOptions()).glb);
    const Json& about = out.json["scenes"][0]["extras"]["lightbatch"];
    ASSERT_EQ(about["page_images"].size(), 2u);
    for (std::size_t k = 0; k < 2; ++k) {
      const Json& image = out.json["images"][about["page_images"][k].get<std::size_t>()];
      EXPECT_EQ(image["name"], "lightmap_" + std::to_string(k));
      EXPECT_TRUE(image.contains("bufferView"));
    }
    // Every material that a mesh draws is in the list of its own original.
    std::set<std::size_t> listed;
    for (const auto& [original, clones] : about["emitters"].items()) {
      const Json& colour = file.json["materials"][std::stoul(original)]["pbrMetallicRoughness"];
      for (const Json& clone : clones) {
        EXPECT_TRUE(listed.insert(clone.get<std::size_t>()).second);
        EXPECT_EQ(out.json["materials"][clone.get<std::size_t>()]["pbrMetallicRoughness"], colour);
      }
    }
    EXPECT_GE(listed.size(), 4u);
    for (const Json& mesh : out.json["meshes"])
      for (const Json& p : mesh["primitives"])
        EXPECT_TRUE(listed.contains(p["material"].get<std::size_t>()));
  }
}

TEST(Lightmap, AnEarlierRunIsNotTakenForThisOne) {
  const Loaded first = load(boxes(3, false).glb());
  const atlas::Layout layout = testing::simple_layout(first.scene, 2);
  const Bytes once = write(first, true, &layout).glb;
  const Loaded second = load(once);
  const atlas::Layout again = testing::simple_layout(second.scene, 2);
  const Json out = testing::read(write(second, true, &again).glb).json;
  std::map<std::string, int> names;
  for (const Json& image : out["images"]) ++names[image["name"].get<std::string>()];
  EXPECT_EQ(names, (std::map<std::string, int>{{"earlier_lightmap_0", 1},
                                               {"earlier_lightmap_1", 1},
                                               {"lightmap_0", 1},
                                               {"lightmap_1", 1}}));
  const Json& pages = out["scenes"][0]["extras"]["lightbatch"]["page_images"];
  EXPECT_EQ(out["images"][pages[0].get<std::size_t>()]["name"], "lightmap_0");
  // Nothing shows the earlier pages: one texel stands for all.
  std::set<std::uint32_t> earlier;
  for (const Json& image : out["images"])
    if (image["name"].get<std::string>().starts_with("earlier_"))
      earlier.insert(image["bufferView"].get<std::uint32_t>());
  ASSERT_EQ(earlier.size(), 1u);
  EXPECT_LT(out["bufferViews"][*earlier.begin()]["byteLength"].get<int>(), 100);
  std::set<std::string> batches;
  for (const Json& node : out["nodes"]) {
    const std::string name = node.value("name", "");
    if (name.starts_with("batch_")) {
      EXPECT_TRUE(batches.insert(name).second) << name;
    }
    if (node.contains("extras") && node["extras"].contains("lightbatch")) {
      EXPECT_TRUE(node.contains("mesh"));
    }
  }
  EXPECT_FALSE(batches.empty());
}

}  // namespace
}  // namespace lightbatch::scene_out
