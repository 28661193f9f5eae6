#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "tests/unit/scene_out/files.h"

namespace lightbatch::scene_out {
namespace {

using testing::FileBuilder;
using testing::Json;
using testing::load;
using testing::Loaded;
using testing::write;

double difference(const Loaded& a, const Bytes& b, double reach) {
  return testing::largest_distance(testing::world_triangles(a), testing::world_triangles(load(b)),
                                   reach);
}

FileBuilder grid(int n, const Json& extra = Json::object()) {
  FileBuilder file;
  for (int i = 0; i < n * n; ++i) {
    Json node{{"mesh", file.mesh({file.cube()})},
              {"name", "cube " + std::to_string(i)},
              {"translation", {3 * (i % n), 0, 3 * (i / n)}},
              {"rotation", {0, 0.38268343, 0, 0.92387953}},
              {"scale", {1, 2, 0.5}}};
    node.update(extra);
    file.node(node);
  }
  return file;
}

TEST(RoundTrip, SameTrianglesInWorldSpace) {
  const Loaded in = load(grid(5).glb());
  // Float positions of a scene of 15 m: 2 ulp of 16 m.
  EXPECT_LT(difference(in, write(in, true).glb, 0.01), 4e-6);
  EXPECT_EQ(difference(in, write(in, false).glb, 0.01), 0);
}

TEST(RoundTrip, FarFromTheOriginKeepsItsPrecision) {
  FileBuilder file = grid(4);
  file.json["nodes"].push_back({{"translation", {1e6, -3e5, 2e6}}, {"children", Json::array()}});
  const std::size_t root = file.json["nodes"].size() - 1;
  for (std::size_t i = 0; i < root; ++i) file.json["nodes"][root]["children"].push_back(i);
  file.json["scenes"][0]["nodes"] = {root};
  const Loaded in = load(file.glb());
  EXPECT_LT(difference(in, write(in, true).glb, 0.01), 4e-6);
  // Positions in the file are small: far values would have lost all but 0.1 m.
  const auto out = testing::read(write(in, true).glb);
  for (const Json& a : out.json["accessors"]) {
    if (!a.contains("min")) continue;
    for (const Json& v : a["min"]) EXPECT_LT(std::abs(v.get<double>()), 100);
  }
}

TEST(RoundTrip, MirroredNodesKeepTheirFronts) {
  const Loaded in = load(grid(3, {{"scale", {-1, 1, 1}}}).glb());
  ASSERT_TRUE(in.scene.objects[0].mirrored);
  const auto out = load(write(in, true).glb);
  EXPECT_FALSE(out.scene.objects[0].mirrored);
  EXPECT_LT(
      testing::largest_distance(testing::world_triangles(in), testing::world_triangles(out), 0.01),
      4e-6);
}

/// Normals point out of the cubes afterwards, tangents keep their side.
TEST(RoundTrip, NormalsTurnWithTheObject) {
  for (const double x : {1.0, -1.0}) {
    const Loaded in = load(grid(2, {{"scale", {x, 2, 0.5}}}).glb());
    const auto out = testing::read(write(in, true).glb);
    for (const Json& mesh : out.json["meshes"]) {
      for (const Json& primitive : mesh["primitives"]) {
        const auto& a = primitive["attributes"];
        const auto p = *gltf::read_values(out, a["POSITION"]);
        const auto n = *gltf::read_values(out, a["NORMAL"]);
        const auto index = *gltf::read_indices(out, primitive["indices"]);
        for (std::size_t i = 0; i < index.size(); i += 3) {
          const auto at = [&](const gltf::Values& v, std::size_t k) {
            const float* f = v.data.data() + 3 * index[i + k];
            return Vec3f{f[0], f[1], f[2]};
          };
          const Vec3f face = normalized(cross(at(p, 1) - at(p, 0), at(p, 2) - at(p, 0)));
          // Flat faces: the vertex normal is the face's, to float precision.
          EXPECT_GT(dot(face, at(n, 0)), 1 - 1e-5f);
        }
      }
    }
  }
}

TEST(RoundTrip, ComponentTypesStayAndBytesFollow) {
  FileBuilder file;
  for (int i = 0; i < 3; ++i) {
    Json cube = file.cube();
    std::vector<std::int8_t> normals;
    for (int v = 0; v < 24; ++v) normals.insert(normals.end(), {0, 127, 0, 0});
    cube["attributes"].erase("NORMAL");
    std::vector<std::uint8_t> colours;
    for (int v = 0; v < 24 * 4; ++v) colours.push_back(static_cast<std::uint8_t>(v));
    cube["attributes"]["COLOR_0"] = file.accessor(colours, 5121, "VEC4", true);
    std::vector<float> custom(24, 0.25f * static_cast<float>(i));
    cube["attributes"]["_AGE"] = file.accessor(custom, 5126, "SCALAR");
    file.node({{"mesh", file.mesh({cube})}, {"translation", {2 * i, 0, 0}}});
  }
  const Loaded in = load(file.glb());
  const auto out = testing::read(write(in, true).glb);
  ASSERT_EQ(out.json["meshes"].size(), 1u);
  const Json& a = out.json["meshes"][0]["primitives"][0]["attributes"];
  const Json& colour = out.json["accessors"][a["COLOR_0"].get<std::size_t>()];
  EXPECT_EQ(colour["componentType"], 5121);
  EXPECT_EQ(colour["normalized"], true);
  EXPECT_EQ(colour["count"], 72);
  const auto age = *gltf::read_values(out, a["_AGE"]);
  for (const float v : {0.0f, 0.25f, 0.5f})
    EXPECT_EQ(std::count(age.data.begin(), age.data.end(), v), 24);
}

TEST(RoundTrip, StripsFansAndUnindexed) {
  FileBuilder file;
  std::vector<float> strip;
  for (int i = 0; i < 8; ++i)
    strip.insert(strip.end(), {0.5f * static_cast<float>(i), static_cast<float>(i % 2), 0});
  const std::uint32_t p = file.positions(strip);
  for (const int mode : {5, 6})
    file.node({{"mesh", file.mesh({{{"attributes", {{"POSITION", p}}}, {"mode", mode}}})},
               {"translation", {0, mode, 0}}});
  file.node({{"mesh", file.mesh({{{"attributes", {{"POSITION", p}}}}})}});
  const Loaded in = load(file.glb());
  EXPECT_GT(in.scene.triangles.size(), 10u);
  EXPECT_LT(difference(in, write(in, true).glb, 0.01), 4e-6);
}

TEST(RoundTrip, RangesCoverEachTriangleOnce) {
  const Loaded in = load(grid(5).glb());
  const auto out = testing::read(write(in, true).glb);
  std::map<std::uint32_t, std::uint64_t> indices_of_node;
  std::size_t batches = 0;
  for (const Json& node : out.json["nodes"]) {
    if (!node.contains("mesh")) continue;
    ++batches;
    const Json& about = node["extras"]["lightbatch"];
    EXPECT_EQ(about["box"].size(), 6u);
    std::map<std::uint32_t, std::uint64_t> next;
    for (const Json& range : about["ranges"]) {
      const auto primitive = range["primitive"].get<std::uint32_t>();
      EXPECT_EQ(range["first"].get<std::uint64_t>(), next[primitive]);
      next[primitive] += range["count"].get<std::uint64_t>();
      const auto source = range["node"].get<std::uint32_t>();
      indices_of_node[source] += range["count"].get<std::uint64_t>();
      EXPECT_EQ(range["name"], in.document.json["nodes"][source]["name"]);
    }
    const Json& mesh = out.json["meshes"][node["mesh"].get<std::size_t>()];
    for (std::uint32_t p = 0; p < mesh["primitives"].size(); ++p) {
      const auto accessor = mesh["primitives"][p]["indices"].get<std::size_t>();
      EXPECT_EQ(out.json["accessors"][accessor]["count"].get<std::uint64_t>(), next[p]);
      EXPECT_EQ(out.json["accessors"][accessor]["componentType"], 5123);
    }
  }
  EXPECT_GT(batches, 0u);
  ASSERT_EQ(indices_of_node.size(), 25u);
  for (const auto& [node, count] : indices_of_node) EXPECT_EQ(count, 36u);
}

TEST(RoundTrip, SameBytesTwice) {
  const Loaded in = load(grid(4).glb());
  EXPECT_EQ(write(in, true).glb, write(in, true).glb);
}

TEST(RoundTrip, GpuInstancesStayOrBecomeNodesWithLight) {
  FileBuilder file;
  std::vector<float> t;
  for (int i = 0; i < 125; ++i)
    t.insert(t.end(), {2.0f * static_cast<float>(i % 5), 2.0f * static_cast<float>(i / 5 % 5),
                       2.0f * static_cast<float>(i / 25)});
  Json node{{"mesh", file.mesh({file.cube()})}};
  node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
      file.accessor(t, 5126, "VEC3");
  file.node(node);
  file.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  const Loaded in = load(file.glb());
  ASSERT_EQ(in.scene.objects.size(), 125u);
  const auto plain = write(in, true);
  EXPECT_LT(difference(in, plain.glb, 0.01), 1e-5);
  EXPECT_LT(static_cast<double>(plain.glb.size()), 1.3 * static_cast<double>(file.glb().size()));

  const atlas::Layout layout = testing::simple_layout(in.scene);
  const auto lit = write(in, true, &layout);
  EXPECT_LT(difference(in, lit.glb, 0.01), 1e-5);
  EXPECT_EQ(testing::read(lit.glb).json.dump().find("EXT_mesh_gpu_instancing"), std::string::npos);
}

/// 12 GPU instances of a cube; `scale` of each is (its value, 1, 1).
FileBuilder scaled_instances(const std::function<float(int)>& scale) {
  FileBuilder file;
  std::vector<float> t, s;
  for (int i = 0; i < 12; ++i) {
    t.insert(t.end(), {3.0f * static_cast<float>(i), 0, 0});
    s.insert(s.end(), {scale(i), 1, 1});
  }
  Json node{{"mesh", file.mesh({file.cube()})}, {"name", "row"}};
  Json& attributes = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  attributes["TRANSLATION"] = file.accessor(t, 5126, "VEC3");
  attributes["SCALE"] = file.accessor(s, 5126, "VEC3");
  file.node(node);
  file.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  return file;
}

TEST(RoundTrip, EachGpuInstanceIsDrawnOnce) {
  const auto mirror = [](int i) { return i % 2 == 0 ? 1.0f : -1.0f; };
  const auto vanish = [](int i) { return i == 3 ? 0.0f : 1.0f; };
  for (const auto& scale : {std::function<float(int)>(mirror), std::function<float(int)>(vanish)}) {
    const Loaded in = load(scaled_instances(scale).glb());
    const atlas::Layout layout = testing::simple_layout(in.scene);
    for (const atlas::Layout* light : {static_cast<const atlas::Layout*>(nullptr), &layout}) {
      const auto out = write(in, true, light);
      EXPECT_EQ(load(out.glb).scene.triangles.size(), in.scene.triangles.size());
      EXPECT_LT(difference(in, out.glb, 0.01), 1e-5);
    }
  }
}

TEST(RoundTrip, AttributesOfGpuInstancesStay) {
  FileBuilder file = scaled_instances([](int) { return 1.0f; });
  std::vector<float> heat;
  for (int i = 0; i < 12; ++i) heat.push_back(0.5f * static_cast<float>(i));
  file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["_HEAT"] =
      file.accessor(heat, 5126, "SCALAR");
  std::vector<std::uint32_t> number;  // floats skip every other one of these
  for (std::uint32_t i = 0; i < 12; ++i) number.push_back((1u << 24) + i);
  file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["_ID"] =
      file.accessor(number, 5125, "SCALAR");
  const Loaded in = load(file.glb());
  const auto plain = write(in, true);
  ASSERT_EQ(plain.plan.left_alone.size(), 12u);
  EXPECT_EQ(plain.plan.left_alone[0].reason, "attribute _HEAT of GPU instances");
  const Json attributes =
      testing::read(plain.glb)
          .json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  EXPECT_TRUE(attributes.contains("_HEAT"));

  // With light, instances become nodes, which keep the values in extras.
  const atlas::Layout layout = testing::simple_layout(in.scene);
  const Json out = testing::read(write(in, true, &layout).glb).json;
  const Json& children = out["nodes"][0]["children"];
  ASSERT_EQ(children.size(), 12u);
  for (std::size_t i = 0; i < 12; ++i) {
    const Json& kept =
        out["nodes"][children[i].get<std::size_t>()]["extras"]["lightbatch"]["attributes"];
    EXPECT_EQ(kept["_HEAT"], Json::array({heat[i]}));
    EXPECT_EQ(kept["_ID"], Json::array({number[i]}));
  }
}

/// Cubes of three materials that differ in base colour, one that differs in more.
FileBuilder painted(const char* third) {
  FileBuilder file;
  file.json["materials"] = {
      {{"name", "red"}, {"pbrMetallicRoughness", {{"baseColorFactor", {0.8, 0, 0, 1}}}}},
      {{"name", "white"}, {"pbrMetallicRoughness", Json::object()}},
      {{"name", "blue"}, {"pbrMetallicRoughness", {{"baseColorFactor", Json::parse(third)}}}},
      {{"name", "dull"}, {"pbrMetallicRoughness", {{"roughnessFactor", 0.5}}}}};
  for (int m = 0; m < 4; ++m) {
    Json cube = file.cube();
    cube["material"] = m;
    file.node({{"mesh", file.mesh({cube})}, {"translation", {2 * m, 0, 0}}});
  }
  return file;
}

TEST(RoundTrip, ConstantColoursGoIntoVertices) {
  for (const auto& [third, type] :
       {std::pair{"[0, 0.2, 1, 1]", 5121}, {"[0, 0.123, 1, 1]", 5126}}) {
    const FileBuilder file = painted(third);
    const Loaded in = load(file.glb());
    const auto written = write(in, true);
    EXPECT_LT(difference(in, written.glb, 0.01), 1e-6);
    const Json out = testing::read(written.glb).json;
    std::size_t coloured = 0;
    for (const Json& mesh : out["meshes"])
      for (const Json& p : mesh["primitives"]) {
        if (!p["attributes"].contains("COLOR_0")) continue;
        ++coloured;
        EXPECT_EQ(out["accessors"][p["attributes"]["COLOR_0"].get<std::size_t>()]["componentType"],
                  type);
      }
    EXPECT_EQ(coloured, 1u);
    EXPECT_EQ(written.plan.draws_after, 2u);
    for (std::size_t m = 0; m < 4; ++m)
      EXPECT_EQ(out["materials"][m], in.document.json["materials"][m]);
    const atlas::Layout layout = testing::simple_layout(in.scene);
    EXPECT_LT(difference(in, write(in, true, &layout).glb, 0.01), 1e-6);
  }
}

TEST(RoundTrip, ColoursStayWhereTheyMeanMore) {
  const auto draws = [](const std::function<void(Json&)>& change) {
    FileBuilder file = painted("[0, 0.2, 1, 1]");
    change(file.json);
    return write(load(file.glb()), true).plan.draws_after;
  };
  EXPECT_EQ(draws([](Json&) {}), 2u);
  EXPECT_EQ(draws([](Json& j) { j["materials"][0]["extras"] = {{"id", 1}}; }), 3u);
  EXPECT_EQ(draws([](Json& j) { j["materials"][0]["doubleSided"] = true; }), 3u);
  EXPECT_EQ(
      draws([](Json& j) { j["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][3] = 0.5; }),
      3u);
  EXPECT_EQ(draws([](Json& j) {
              j["extensionsUsed"] = {"EXT_paint"};
              j["materials"][0]["extensions"]["EXT_paint"] = Json::object();
            }),
            3u);
}

/// Materials that differ in the name alone share draws, with a texture and without.
TEST(RoundTrip, TwinsOfMaterialsNeedNoColours) {
  for (const bool textured : {false, true}) {
    FileBuilder file = painted("[0, 0.2, 1, 1]");
    const std::vector<std::uint8_t> signature{0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a};
    file.accessor(signature, 5121, "SCALAR");
    const std::size_t view = file.json["bufferViews"].size() - 1;
    file.json["accessors"].erase(file.json["accessors"].size() - 1);
    file.json["images"] = {{{"bufferView", view}, {"mimeType", "image/png"}}};
    file.json["textures"] = {{{"source", 0}}};
    for (Json& material : file.json["materials"]) {
      Json twin = file.json["materials"][0];
      twin["name"] = material["name"];
      if (textured) twin["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
      material = std::move(twin);
    }
    const Loaded in = load(file.glb());
    const auto written = write(in, true);
    EXPECT_EQ(written.plan.draws_after, 1u);
    const Json out = testing::read(written.glb).json;
    EXPECT_EQ(out["materials"].size(), 4u);
    for (const Json& mesh : out["meshes"])
      for (const Json& p : mesh["primitives"]) EXPECT_FALSE(p["attributes"].contains("COLOR_0"));
    std::set<std::uint32_t> materials;
    for (const Json& node : out["nodes"])
      if (node.contains("extras"))
        for (const Json& range : node["extras"]["lightbatch"]["ranges"])
          materials.insert(range["material"].get<std::uint32_t>());
    EXPECT_EQ(materials, (std::set<std::uint32_t>{0, 1, 2, 3}));
    if (!textured) continue;
    // The factor stays in the material.
    file.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {0.5, 0, 0, 1};
    EXPECT_EQ(write(load(file.glb()), true).plan.draws_after, 2u);
  }
}

TEST(RoundTrip, MeshoptViewsDecodeToTheSameScene) {
  const FileBuilder file = painted("[0, 0.2, 1, 1]");
  const Loaded in = load(file.glb());
  WriteOptions options;
  options.compression = Compression::kMeshopt;
  const Bytes glb = write(in, true, nullptr, {}, options).glb;
  const Loaded out = load(glb);
  EXPECT_TRUE(out.document.had_meshopt);
  EXPECT_LT(difference(in, glb, 0.01), 1e-6);
  EXPECT_LT(glb.size(), write(in, true).glb.size());
}

}  // namespace
}  // namespace lightbatch::scene_out
