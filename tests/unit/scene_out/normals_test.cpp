#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>

#include "tests/unit/scene_out/files.h"

namespace lightbatch::scene_out {
namespace {

using testing::FileBuilder;
using testing::Json;
using testing::load;
using testing::write;

using Bytes3 = std::array<int, 3>;

/// A cube whose normals are these bytes by turns.
Json cube_of_bytes(FileBuilder& file, const std::vector<Bytes3>& directions) {
  Json cube = file.cube();
  std::vector<std::int8_t> normals;
  for (std::size_t v = 0; v < 24; ++v) {
    for (const int c : directions[v % directions.size()])
      normals.push_back(static_cast<std::int8_t>(c));
    normals.push_back(0);
  }
  const std::uint32_t a = file.accessor(normals, 5120, "VEC4", true);
  file.json["accessors"][a]["type"] = "VEC3";
  file.json["bufferViews"].back()["byteStride"] = 4;
  cube["attributes"]["NORMAL"] = a;
  file.json["extensionsUsed"] = file.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  return cube;
}

/// Moved, scaled evenly, turned by right angles: byte normals stay what they are.
TEST(Normals, BytesOfNormalsAreRoundedOnce) {
  const std::vector<Bytes3> directions{{117, 50, 10}, {20, -52, 115}, {-90, 90, 1}, {0, 127, 0}};
  const double half = std::sqrt(0.5);
  for (const Json& turn : {Json{{"translation", {3, 4, 5}}}, Json{{"scale", {2.5, 2.5, 2.5}}},
                           Json{{"rotation", {0, half, 0, half}}}}) {
    FileBuilder file;
    for (int i = 0; i < 2; ++i) {
      Json node = turn;
      node["mesh"] = file.mesh({cube_of_bytes(file, directions)});
      if (i == 1) node["translation"] = {9, 0, 0};
      file.node(node);
    }
    std::set<Bytes3> expected;
    for (const Bytes3& d : directions)
      expected.insert(turn.contains("rotation") ? Bytes3{d[2], d[1], -d[0]} : d);
    const auto out = testing::read(write(load(file.glb()), true).glb);
    for (const Json& mesh : out.json["meshes"]) {
      const std::uint32_t accessor = mesh["primitives"][0]["attributes"]["NORMAL"];
      ASSERT_EQ(out.json["accessors"][accessor]["componentType"], 5120);
      const Bytes packed = *gltf::read_packed(out, accessor);
      std::set<Bytes3> found;
      for (std::size_t i = 0; i + 3 <= packed.size(); i += 3) {
        Bytes3 normal{};
        for (std::size_t c = 0; c < 3; ++c) normal[c] = static_cast<std::int8_t>(packed[i + c]);
        found.insert(normal);
      }
      EXPECT_EQ(found, expected) << turn;
    }
  }
}

/// Half a step of a byte is 0.2 degrees: a second one would double what the first left.
TEST(Normals, OtherTurnsDoNotRoundBytesAgain) {
  const std::vector<Bytes3> directions{{117, 50, 10}, {20, -52, 115}, {-90, 90, 1}, {0, 127, 0}};
  const double angle = 0.7;
  FileBuilder file;
  for (int i = 0; i < 2; ++i)
    file.node({{"mesh", file.mesh({cube_of_bytes(file, directions)})},
               {"translation", {9 * i, 0, 0}},
               {"rotation", {0, std::sin(angle / 2), 0, std::cos(angle / 2)}}});
  const auto out = testing::read(write(load(file.glb()), true).glb);
  const auto normals =
      *gltf::read_values(out, out.json["meshes"].back()["primitives"][0]["attributes"]["NORMAL"]);
  ASSERT_FALSE(normals.data.empty());
  for (std::size_t i = 0; i + 2 < normals.data.size(); i += 3) {
    const Vec3d n{double{normals.data[i]}, double{normals.data[i + 1]},
                  double{normals.data[i + 2]}};
    double nearest = INFINITY;
    for (const Bytes3& d : directions) {
      const double x = d[0], z = d[2];
      const Vec3d turned =
          normalized(Vec3d{std::cos(angle) * x + std::sin(angle) * z, static_cast<double>(d[1]),
                      std::cos(angle) * z - std::sin(angle) * x});
      nearest = std::min(nearest, length(n - turned));
    }
    EXPECT_LT(nearest, 1e-4);
  }
}

}  // namespace
}  // namespace lightbatch::scene_out
