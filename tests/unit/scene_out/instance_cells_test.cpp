#include <gtest/gtest.h>

#include <map>

#include "tests/unit/scene_out/files.h"

namespace lightbatch::scene_out {
namespace {

using testing::FileBuilder;
using testing::Json;
using testing::load;
using testing::Loaded;
using testing::write;

TEST(InstanceCells, SharedMeshesInPartsDrawTheSameTriangles) {
  FileBuilder file;
  file.json["materials"] = {
      {{"name", "red"}, {"pbrMetallicRoughness", {{"baseColorFactor", {0.8, 0, 0, 1}}}}},
      {{"name", "white"}, {"pbrMetallicRoughness", Json::object()}}};
  std::vector<float> p;
  std::vector<std::uint16_t> index;
  constexpr int kSide = 100;
  for (int y = 0; y <= kSide; ++y)
    for (int x = 0; x <= kSide; ++x)
      p.insert(p.end(), {static_cast<float>(x), 0, static_cast<float>(y)});
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const int a = y * (kSide + 1) + x, b = a + kSide + 1;
      for (const int v : {a, b, a + 1, a + 1, b, b + 1})
        index.push_back(static_cast<std::uint16_t>(v));
    }
  Json floor{{"attributes", {{"POSITION", file.positions(p)}}},
             {"indices", file.accessor(index, 5123, "SCALAR")},
             {"material", 0}};
  Json second = floor;
  second["attributes"]["POSITION"] = file.positions(p);
  second["material"] = 1;
  const std::uint32_t mesh = file.mesh({floor, second});
  for (int i = 0; i < 6; ++i)
    file.node({{"mesh", mesh}, {"translation", {105 * (i % 2), 0, 105 * (i / 2)}}});
  const Loaded in = load(file.glb());
  const auto out = write(in, true);
  EXPECT_GT(out.plan.parts.size(), 1u);
  EXPECT_LT(testing::largest_distance(testing::world_triangles(in),
                                      testing::world_triangles(load(out.glb)), 0.1),
            1e-4);
  // Cells of parts say where their indices came from: each placement draws every triangle once.
  const Json written = load(out.glb).document.json;
  std::map<std::uint32_t, std::uint64_t> drawn;
  for (const Json& node : written["nodes"]) {
    if (!node.contains("extras")) continue;
    const Json& about = node["extras"]["lightbatch"];
    if (!about.contains("nodes")) continue;
    std::uint64_t indices = 0;
    for (const Json& range : about["ranges"]) {
      EXPECT_EQ(range["material"], range["source_primitive"]);
      indices += range["count"].get<std::uint64_t>();
    }
    for (const Json& source : about["nodes"]) drawn[source.get<std::uint32_t>()] += indices;
  }
  ASSERT_EQ(drawn.size(), 6u);
  for (const auto& [node, indices] : drawn) EXPECT_EQ(indices, 2 * index.size());
  // 12 bytes of a vertex become 16, and the input has one list of indices for both primitives.
  EXPECT_LT(static_cast<double>(out.glb.size()), 1.8 * static_cast<double>(file.glb().size()));
}

TEST(InstanceCells, PrimitivesHaveNoMoreVerticesThanAsked) {
  FileBuilder file;
  const std::uint32_t mesh = file.mesh({file.cube()});
  for (int i = 0; i < 60; ++i)
    file.node({{"mesh", mesh}, {"translation", {40 * (i % 8), i % 3, 40 * (i / 8)}}});
  const Loaded in = load(file.glb());
  batches::BatchOptions options;
  options.max_vertices = 10;  // of a cube's 24
  const auto out = write(in, true, nullptr, options);
  ASSERT_FALSE(out.plan.cells.empty());
  const Loaded again = load(out.glb);
  for (const scene::Object& object : again.scene.objects) {
    const Json& written = again.document.json["meshes"][object.mesh]["primitives"];
    const Json& positions = written[object.primitive]["attributes"]["POSITION"];
    EXPECT_LE(again.document.json["accessors"][positions.get<std::size_t>()]["count"], 10);
  }
  EXPECT_LT(
      testing::largest_distance(testing::world_triangles(in), testing::world_triangles(again), 0.1),
      1e-4);
}

TEST(InstanceCells, DrawTheSameTriangles) {
  FileBuilder file;
  const std::uint32_t mesh = file.mesh({file.cube()});
  for (int i = 0; i < 60; ++i)
    file.node({{"mesh", mesh},
               {"translation", {40 * (i % 8), i % 3, 40 * (i / 8)}},
               {"rotation", {0.5, 0.5, 0.5, 0.5}},
               {"scale", {1, 2, 3}}});
  const Loaded in = load(file.glb());
  const auto out = write(in, true);
  ASSERT_FALSE(out.plan.cells.empty());
  EXPECT_LT(testing::largest_distance(testing::world_triangles(in),
                                      testing::world_triangles(load(out.glb)), 0.1),
            1e-4);
}

}  // namespace
}  // namespace lightbatch::scene_out
