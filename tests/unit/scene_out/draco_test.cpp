#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/scene_out/files.h"

namespace lightbatch::scene_out {
namespace {

using testing::FileBuilder;
using testing::Json;
using testing::load;
using testing::Loaded;
using testing::write;

FileBuilder grid(int n) {
  FileBuilder file;
  for (int i = 0; i < n * n; ++i)
    file.node({{"mesh", file.mesh({file.cube()})},
               {"translation", {3 * (i % n), 0, 3 * (i / n)}},
               {"rotation", {0, 0.38268343, 0, 0.92387953}},
               {"scale", {1, 2, 0.5}}});
  return file;
}

/// World positions of all vertices of batches, mesh by mesh.
std::vector<Vec3d> batch_vertices(const gltf::Document& document) {
  std::vector<Vec3d> all;
  for (const Json& node : document.json["nodes"]) {
    if (!node.contains("mesh")) continue;
    Vec3d t;
    if (node.contains("translation"))
      t = {node["translation"][0], node["translation"][1], node["translation"][2]};
    const Json& mesh = document.json["meshes"][node["mesh"].get<std::size_t>()];
    for (const Json& primitive : mesh["primitives"]) {
      const auto p = *gltf::read_values(document, primitive["attributes"]["POSITION"]);
      for (std::size_t i = 0; i < p.data.size(); i += 3)
        all.push_back(t + to_double(Vec3f{p.data[i], p.data[i + 1], p.data[i + 2]}));
    }
  }
  return all;
}

TEST(Draco, RoundsToOneGridAndKeepsTheOrder) {
  const Loaded in = load(grid(5).glb());
  WriteOptions options;
  options.compression = Compression::kDraco;
  const Bytes plain_glb = write(in, true).glb, glb = write(in, true, nullptr, {}, options).glb;
  const gltf::Document plain = testing::read(plain_glb), out = testing::read(glb);
  EXPECT_TRUE(out.had_draco);
  EXPECT_LT(glb.size(), plain_glb.size());
  EXPECT_EQ(glb, write(in, true, nullptr, {}, options).glb);

  // Ranges of indices stay true: same triangles in the same order.
  ASSERT_EQ(out.json["meshes"].size(), plain.json["meshes"].size());
  for (std::size_t m = 0; m < out.json["meshes"].size(); ++m) {
    const Json &a = plain.json["meshes"][m]["primitives"], &b = out.json["meshes"][m]["primitives"];
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k)
      EXPECT_EQ(*gltf::read_indices(plain, a[k]["indices"]),
                *gltf::read_indices(out, b[k]["indices"]));
  }
  // A batch of 14 m: 2^3 / 2^14 m is the step, half of it the error along an axis. Vertices that
  // met still meet.
  const auto before = batch_vertices(plain), after = batch_vertices(out);
  ASSERT_EQ(before.size(), after.size());
  const double step = std::exp2(-11);
  for (std::size_t i = 0; i < before.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_LE(std::abs(before[i][axis] - after[i][axis]), 0.5 * step + 1e-6);
      // On the grid, to an ulp of what the decoder computes.
      EXPECT_LT(std::abs(std::remainder(after[i][axis], step)), 1e-6);
    }
  }
}

TEST(Draco, RoundsTangentsAndKeepsTheirSigns) {
  FileBuilder file;
  for (int i = 0; i < 4; ++i) {
    Json cube = file.cube();
    std::vector<float> tangents;
    for (int v = 0; v < 24; ++v) {
      const float angle = 0.3f * static_cast<float>(v + i);
      tangents.insert(tangents.end(),
                      {std::cos(angle), std::sin(angle), 0.0f, v % 2 == 0 ? 1.0f : -1.0f});
    }
    cube["attributes"]["TANGENT"] = file.accessor(tangents, 5126, "VEC4");
    file.node({{"mesh", file.mesh({cube})}, {"translation", {2 * i, 0, 0}}});
  }
  WriteOptions options;
  options.compression = Compression::kDraco;
  const Loaded in = load(file.glb());
  const auto plain = testing::read(write(in, true).glb);
  const auto out = testing::read(write(in, true, nullptr, {}, options).glb);
  std::size_t compared = 0;
  for (std::size_t m = 0; m < out.json["meshes"].size(); ++m) {
    const auto tangents = [m](const gltf::Document& file_) {
      return *gltf::read_values(file_,
                                file_.json["meshes"][m]["primitives"][0]["attributes"]["TANGENT"]);
    };
    const auto before = tangents(plain), after = tangents(out);
    ASSERT_EQ(before.data.size(), after.data.size());
    for (std::size_t i = 0; i < before.data.size(); ++i, ++compared) {
      if (i % 4 == 3)
        EXPECT_NEAR(before.data[i], after.data[i], 1e-6);
      else
        EXPECT_NEAR(before.data[i], after.data[i], std::exp2(-12) + 1e-7);
    }
  }
  EXPECT_EQ(compared, 4u * 24 * 4);
}

TEST(Draco, VerticesWithoutATriangleAreDropped) {
  // Decoders refuse streams of more points than corners; a node that is animated keeps its mesh.
  FileBuilder file = grid(2);
  const Json cube = file.cube();
  Json corner = cube;
  corner["indices"] = file.accessor(std::vector<std::uint16_t>{20, 21, 22}, 5123, "SCALAR");
  const std::uint32_t node = file.node({{"mesh", file.mesh({corner})}, {"name", "corner"}});
  const std::uint32_t times = file.accessor(std::vector<float>{0, 1}, 5126, "SCALAR");
  file.json["accessors"][times].update(Json{{"min", {0}}, {"max", {1}}});
  const std::uint32_t ways = file.accessor(std::vector<float>{0, 0, 0, 1, 0, 0}, 5126, "VEC3");
  Json animation;
  animation["samplers"] = {{{"input", times}, {"output", ways}}};
  animation["channels"] = {{{"sampler", 0}, {"target", {{"node", node}, {"path", "translation"}}}}};
  file.json["animations"] = {animation};
  WriteOptions options;
  options.compression = Compression::kDraco;
  const Loaded in = load(file.glb());
  const auto out = testing::read(write(in, true, nullptr, {}, options).glb);
  const Json& kept = out.json["meshes"][out.json["nodes"][node]["mesh"].get<std::size_t>()];
  const std::uint32_t accessor = kept["primitives"][0]["attributes"]["POSITION"];
  const auto before = *gltf::read_values(in.document, cube["attributes"]["POSITION"]);
  const auto after = *gltf::read_values(out, accessor);
  ASSERT_EQ(after.count(), 3u);
  std::vector<float> low(3, 9), high(3, -9);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(after.data[i], before.data[60 + i], 1e-3);
    low[i % 3] = std::min(low[i % 3], after.data[i]);
    high[i % 3] = std::max(high[i % 3], after.data[i]);
  }
  EXPECT_EQ(out.json["accessors"][accessor]["min"].get<std::vector<float>>(), low);
  EXPECT_EQ(out.json["accessors"][accessor]["max"].get<std::vector<float>>(), high);
}

TEST(Draco, TrianglesThatPackWellAreStoredPlainly) {
  // Many triangles on one spot: decoders refuse streams of fewer than 3 bytes a triangle.
  FileBuilder file;
  std::vector<std::uint16_t> indices;
  for (int i = 0; i < 1000; ++i) indices.insert(indices.end(), {0, 1, 2});
  Json pile{{"attributes", {{"POSITION", file.positions({0, 0, 0, 1, 0, 0, 0, 1, 0})}}}};
  pile["indices"] = file.accessor(indices, 5123, "SCALAR");
  file.node({{"mesh", file.mesh({pile})}});
  WriteOptions options;
  options.compression = Compression::kDraco;
  const auto out = testing::read(write(load(file.glb()), true, nullptr, {}, options).glb);
  EXPECT_TRUE(out.had_draco);
  EXPECT_EQ(gltf::read_indices(out, out.json["meshes"][0]["primitives"][0]["indices"])->size(),
            3000u);
}

TEST(Draco, LeavesWhatItCannotHold) {
  FileBuilder file = grid(2);
  Json morphed = file.cube();
  morphed["targets"] = {{{"POSITION", morphed["attributes"]["POSITION"]}}};
  file.node({{"mesh", file.mesh({morphed})}});
  WriteOptions options;
  options.compression = Compression::kDraco;
  const Loaded in = load(file.glb());
  const auto out = testing::read(write(in, true, nullptr, {}, options).glb);
  EXPECT_TRUE(out.had_draco);
  std::size_t morphs = 0;
  for (const Json& mesh : out.json["meshes"])
    for (const Json& primitive : mesh["primitives"])
      if (primitive.contains("targets")) {
        ++morphs;
        EXPECT_EQ(*gltf::read_packed(out, primitive["attributes"]["POSITION"]),
                  *gltf::read_packed(in.document, morphed["attributes"]["POSITION"]));
      }
  EXPECT_EQ(morphs, 1u);
}

}  // namespace
}  // namespace lightbatch::scene_out
