#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

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

/// Corners of the triangles of one range of a batch, in the world, sorted.
using Corner = std::array<double, 3>;
std::vector<Corner> range_corners(const gltf::Document& document, const Json& node,
                                  const Json& range) {
  const Json& mesh = document.json["meshes"][node["mesh"].get<std::size_t>()];
  const Json& primitive = mesh["primitives"][range["primitive"].get<std::size_t>()];
  const auto positions = *gltf::read_values(document, primitive["attributes"]["POSITION"]);
  const auto indices = *gltf::read_indices(document, primitive["indices"]);
  std::vector<Corner> corners;
  for (std::size_t i = 0; i < range["count"].get<std::size_t>(); ++i) {
    const std::size_t v = 3 * indices.at(range["first"].get<std::size_t>() + i);
    Corner corner{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      corner[axis] = double{positions.data[v + axis]} + node["translation"][axis].get<double>();
    corners.push_back(corner);
  }
  std::sort(corners.begin(), corners.end());
  return corners;
}

double largest_difference(const std::vector<Corner>& a, const std::vector<Corner>& b) {
  double largest = a.size() == b.size() ? 0 : INFINITY;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      largest = std::max(largest, std::abs(a[i][axis] - b[i][axis]));
  return largest;
}

/// Rows of closed cubes and of open halves, of whole metres.
FileBuilder cubes_and_halves(int n, double scale) {
  FileBuilder file;
  for (int i = 0; i < n * n; ++i) {
    Json cube = file.cube();
    if (i % 2 == 1)
      cube["indices"] = file.accessor(
          std::vector<std::uint16_t>{0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 8, 10, 9}, 5123, "SCALAR");
    file.node({{"mesh", file.mesh({cube})},
               {"translation", {2 * scale * (i % n), 0, 2 * scale * (i / n)}},
               {"scale", {scale, scale, scale}}});
  }
  return file;
}

TEST(Draco, RangesSayWhereTheirTrianglesWent) {
  const Loaded in = load(cubes_and_halves(5, 1).glb());
  WriteOptions options;
  options.compression = Compression::kDraco;
  const Bytes plain_glb = write(in, true).glb, glb = write(in, true, nullptr, {}, options).glb;
  const gltf::Document plain = testing::read(plain_glb), out = testing::read(glb);
  EXPECT_TRUE(out.had_draco);
  EXPECT_LT(glb.size(), plain_glb.size());
  EXPECT_EQ(glb, write(in, true, nullptr, {}, options).glb);
  ASSERT_EQ(out.json["nodes"].size(), plain.json["nodes"].size());
  std::size_t compared = 0, moved = 0;
  for (std::size_t n = 0; n < out.json["nodes"].size(); ++n) {
    const Json &a = plain.json["nodes"][n], &b = out.json["nodes"][n];
    if (!a.contains("extras") || !a.contains("mesh")) continue;
    const Json &before = a["extras"]["lightbatch"]["ranges"],
               &after = b["extras"]["lightbatch"]["ranges"];
    ASSERT_EQ(before.size(), after.size());
    for (std::size_t r = 0; r < before.size(); ++r, ++compared) {
      EXPECT_EQ(before[r]["node"], after[r]["node"]);
      EXPECT_EQ(before[r]["count"], after[r]["count"]);
      moved += before[r]["first"] != after[r]["first"];
      EXPECT_LT(
          largest_difference(range_corners(plain, a, before[r]), range_corners(out, b, after[r])),
          1e-6);
    }
  }
  EXPECT_EQ(compared, 25u);
  EXPECT_GT(moved, 0u);
}

/// The step is a power of two whatever the unit; half of it is the error along an axis. Vertices
/// that met still meet.
TEST(Draco, RoundsToOneGridInAnyUnit) {
  for (const double scale : {1.0, 0.3, 3e-4, 3e-7}) {
    FileBuilder file;
    for (int i = 0; i < 16; ++i)
      file.node({{"mesh", file.mesh({file.cube()})},
                 {"translation", {3 * scale * (i % 4), 0, 3 * scale * (i / 4)}},
                 {"rotation", {0, 0.38268343, 0, 0.92387953}},
                 {"scale", {scale, 2 * scale, 0.5 * scale}}});
    WriteOptions options;
    options.compression = Compression::kDraco;
    const Loaded in = load(file.glb());
    const auto plain = testing::read(write(in, true).glb);
    const auto out = testing::read(write(in, true, nullptr, {}, options).glb);
    // One batch, of 9 to 14 cubes' edges.
    const double step = std::exp2(std::floor(std::log2(10 * scale)) - 14);
    std::size_t compared = 0;
    for (std::size_t n = 0; n < out.json["nodes"].size(); ++n) {
      const Json &a = plain.json["nodes"][n], &b = out.json["nodes"][n];
      if (!a.contains("extras") || !a.contains("mesh")) continue;
      for (std::size_t r = 0; r < a["extras"]["lightbatch"]["ranges"].size(); ++r, ++compared) {
        const auto before = range_corners(plain, a, a["extras"]["lightbatch"]["ranges"][r]);
        const auto after = range_corners(out, b, b["extras"]["lightbatch"]["ranges"][r]);
        EXPECT_LT(largest_difference(before, after), 1.01 * step) << scale;
        for (const Corner& corner : after)
          for (const double v : corner)
            EXPECT_LT(std::abs(std::remainder(v, step)), 0.01 * step) << scale;
      }
    }
    EXPECT_EQ(compared, 16u);
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
  // Rounding does not change which place has which tangent.
  using Vertex = std::array<double, 7>;
  const auto vertices = [](const gltf::Document& document) {
    std::set<Vertex> all;
    for (const Json& mesh : document.json["meshes"])
      for (const Json& primitive : mesh["primitives"]) {
        const auto p = *gltf::read_values(document, primitive["attributes"]["POSITION"]);
        const auto t = *gltf::read_values(document, primitive["attributes"]["TANGENT"]);
        for (std::size_t v = 0; v < p.count(); ++v) {
          Vertex vertex{};
          for (std::size_t k = 0; k < 3; ++k)
            vertex[k] = std::round(double{p.data[3 * v + k]} * 100);
          for (std::size_t k = 0; k < 4; ++k)
            vertex[3 + k] = std::round(double{t.data[4 * v + k]} * 100) / 100;
          all.insert(vertex);
        }
      }
    return all;
  };
  const auto before = vertices(plain), after = vertices(out);
  EXPECT_EQ(before.size(), 4u * 24);
  ASSERT_EQ(before.size(), after.size());
  for (auto a = before.begin(), b = after.begin(); a != before.end(); ++a, ++b) {
    for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR((*a)[k], (*b)[k], 0.011);
    EXPECT_EQ((*a)[6], (*b)[6]);
  }
}

TEST(Draco, SkinsAreCompressed) {
  FileBuilder file;
  Json cube = file.cube();
  std::vector<std::uint8_t> joints;
  std::vector<float> weights;
  for (int v = 0; v < 24; ++v) {
    joints.insert(joints.end(), {0, 1, 0, 0});
    const float share = static_cast<float>(v) / 24;
    weights.insert(weights.end(), {share, 1 - share, 0, 0});
  }
  cube["attributes"]["JOINTS_0"] = file.accessor(joints, 5121, "VEC4");
  cube["attributes"]["WEIGHTS_0"] = file.accessor(weights, 5126, "VEC4");
  const std::uint32_t hip = file.node({{"name", "hip"}}), knee = hip + 1;
  file.json["nodes"].push_back({{"name", "knee"}});
  file.json["nodes"][hip]["children"] = {knee};
  file.json["skins"] = {{{"joints", {hip, knee}}}};
  file.node({{"mesh", file.mesh({cube})}, {"skin", 0}});
  WriteOptions options;
  options.compression = Compression::kDraco;
  const Loaded in = load(file.glb());
  const auto out = testing::read(write(in, true, nullptr, {}, options).glb);
  ASSERT_TRUE(out.had_draco);
  const Json& attributes = out.json["meshes"][0]["primitives"][0]["attributes"];
  const auto values = gltf::read_values(out, attributes["WEIGHTS_0"])->data;
  EXPECT_EQ(std::set<float>(values.begin(), values.end()),
            std::set<float>(weights.begin(), weights.end()));
  EXPECT_EQ(out.json["accessors"][attributes["JOINTS_0"].get<std::size_t>()]["componentType"],
            5121);
}

TEST(Draco, SmallMeshesAmongLargeOnesKeepTheirShape) {
  FileBuilder file;
  for (int i = 0; i < 4; ++i)
    file.node({{"mesh", file.mesh({file.cube()})},
               {"translation", {2000 * i, 0, 0}},
               {"scale", {1000, 1000, 1000}}});
  // Moves, so it stays in its node.
  const std::vector<float> corners{0.11f, 0.23f, 0.37f, 0.91f, 0.29f, 0.41f, 0.47f, 0.83f, 0.33f};
  Json small{{"attributes", {{"POSITION", file.positions(corners)}}}};
  small["indices"] = file.accessor(std::vector<std::uint16_t>{0, 1, 2}, 5123, "SCALAR");
  const std::uint32_t node = file.node({{"mesh", file.mesh({small})}});
  file.animate(node, {0, 0, 0, 1, 0, 0});
  WriteOptions options;
  options.compression = Compression::kDraco;
  const auto out = testing::read(write(load(file.glb()), true, nullptr, {}, options).glb);
  const Json& kept = out.json["meshes"][out.json["nodes"][node]["mesh"].get<std::size_t>()];
  const auto found = *gltf::read_values(out, kept["primitives"][0]["attributes"]["POSITION"]);
  ASSERT_EQ(found.count(), 3u);
  for (const float value : found.data)
    EXPECT_TRUE(std::any_of(corners.begin(), corners.end(), [&](float corner) {
      return std::abs(corner - value) < 1e-3f;
    })) << value;
}

TEST(Draco, VerticesWithoutATriangleAreDropped) {
  // Decoders refuse streams of more points than corners; a node that is animated keeps its mesh.
  FileBuilder file = grid(2);
  const Json cube = file.cube();
  Json corner = cube;
  corner["indices"] = file.accessor(std::vector<std::uint16_t>{20, 21, 22}, 5123, "SCALAR");
  const std::uint32_t node = file.node({{"mesh", file.mesh({corner})}, {"name", "corner"}});
  file.animate(node, {0, 0, 0, 1, 0, 0});
  WriteOptions options;
  options.compression = Compression::kDraco;
  const Loaded in = load(file.glb());
  const auto out = testing::read(write(in, true, nullptr, {}, options).glb);
  const Json& kept = out.json["meshes"][out.json["nodes"][node]["mesh"].get<std::size_t>()];
  const std::uint32_t accessor = kept["primitives"][0]["attributes"]["POSITION"];
  const auto before = *gltf::read_values(in.document, cube["attributes"]["POSITION"]);
  const auto after = *gltf::read_values(out, accessor);
  ASSERT_EQ(after.count(), 3u);
  const std::vector<float> corners(before.data.begin() + 60, before.data.begin() + 69);
  std::vector<float> low(3, 9), high(3, -9);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_EQ(std::count(corners.begin(), corners.end(), after.data[i]),
              std::count(after.data.begin(), after.data.end(), after.data[i]));
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

/// No grid holds these: they are stored as they are.
TEST(Draco, HugeTextureCoordinatesStayExact) {
  for (const float huge : {1e10f, 1e30f, 3e38f}) {
    FileBuilder file;
    Json cube = file.cube();
    std::vector<float> uv(48, 0.5f);
    uv[7] = huge;
    uv[8] = -huge;
    cube["attributes"]["TEXCOORD_0"] = file.accessor(uv, 5126, "VEC2");
    file.node({{"mesh", file.mesh({cube})}});
    WriteOptions options;
    options.compression = Compression::kDraco;
    const auto out = testing::read(write(load(file.glb()), true, nullptr, {}, options).glb);
    EXPECT_TRUE(out.had_draco);
    const auto after =
        *gltf::read_values(out, out.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"]);
    EXPECT_EQ(std::count(after.data.begin(), after.data.end(), huge), 1) << huge;
    EXPECT_EQ(std::count(after.data.begin(), after.data.end(), -huge), 1) << huge;
  }
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
