#include "core/generate/office.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/generate/materials.h"
#include "core/generate/shell.h"

namespace lightbatch::generate {
namespace {

using nlohmann::json;

struct Glb {
  json document;
  Bytes binary;
};

/// Takes a .glb apart by its specification (header of 12 bytes, JSON chunk, binary chunk).
Glb parse(const Bytes& bytes) {
  const auto word = [&](std::size_t offset) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + offset, 4);
    return value;
  };
  EXPECT_EQ(word(0), 0x46546C67u);
  EXPECT_EQ(word(4), 2u);
  EXPECT_EQ(word(8), bytes.size());
  const std::size_t json_size = word(12);
  const auto text = as_text(std::span(bytes).subspan(20, json_size));
  const std::size_t binary_at = 20 + json_size + 8;
  return {json::parse(text),
          Bytes(bytes.begin() + static_cast<std::ptrdiff_t>(binary_at), bytes.end())};
}

std::uint64_t triangles_of_mesh(const json& document, const json& mesh) {
  std::uint64_t sum = 0;
  for (const json& primitive : mesh["primitives"]) {
    sum += document["accessors"][primitive["indices"].get<std::size_t>()]["count"]
               .get<std::uint64_t>() /
           3;
  }
  return sum;
}

/// Triangles drawn, walking the scene from its roots.
std::uint64_t drawn_triangles(const json& document) {
  std::uint64_t sum = 0;
  std::vector<std::size_t> open = document["scenes"][0]["nodes"].get<std::vector<std::size_t>>();
  while (!open.empty()) {
    const json& node = document["nodes"][open.back()];
    open.pop_back();
    if (node.contains("mesh")) {
      sum += triangles_of_mesh(document, document["meshes"][node["mesh"].get<std::size_t>()]);
    }
    if (node.contains("children")) {
      for (const json& child : node["children"]) open.push_back(child.get<std::size_t>());
    }
  }
  return sum;
}

TEST(Office, HoldsTheTrianglesAskedFor) {
  for (const int size : {1'000, 1'500, 2'000, 3'000, 4'500, 5'000, 7'000, 10'000, 20'000, 50'000,
                         100'000, 300'000, 1'000'000, 4'000'000, 12'000'000}) {
    const auto asked = static_cast<std::uint64_t>(size);
    const Result<Bytes> office = office_glb(asked, 1);
    ASSERT_TRUE(office.ok()) << office.status().to_string();
    const double drawn = static_cast<double>(drawn_triangles(parse(*office).document));
    EXPECT_NEAR(drawn / static_cast<double>(asked), 1, 0.03) << asked;
  }
}

TEST(Office, EverySeedIsAnotherOfficeAndTheSameOneTwice) {
  std::set<std::string> texts;
  for (const std::uint64_t seed : {0ull, 1ull, 2ull, ~0ull}) {
    const Result<Bytes> first = office_glb(6'000, seed);
    const Result<Bytes> second = office_glb(6'000, seed);
    ASSERT_TRUE(first.ok());
    EXPECT_EQ(*first, *second);
    texts.emplace(as_text(*first));
  }
  EXPECT_EQ(texts.size(), 4u);
}

TEST(Office, RefusesSizesOutsideItsBounds) {
  for (const std::uint64_t asked : {std::uint64_t{0}, kFewestTriangles - 1, kMostTriangles + 1}) {
    const Result<Bytes> office = office_glb(asked, 1);
    ASSERT_FALSE(office.ok());
    EXPECT_EQ(office.status().reason(), "BAD_OPTION");
  }
}

TEST(Office, DocumentIsSound) {
  const Result<Bytes> office = office_glb(30'000, 5);
  ASSERT_TRUE(office.ok());
  const Glb glb = parse(*office);
  const json& document = glb.document;
  // Every accessor lies in its view, every view in the buffer, every index below its vertex count.
  for (const json& view : document["bufferViews"]) {
    EXPECT_LE(view["byteOffset"].get<std::size_t>() + view["byteLength"].get<std::size_t>(),
              glb.binary.size());
  }
  for (const json& mesh : document["meshes"]) {
    for (const json& primitive : mesh["primitives"]) {
      const json& indices = document["accessors"][primitive["indices"].get<std::size_t>()];
      const auto vertices =
          document["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()]["count"]
              .get<std::size_t>();
      const json& view = document["bufferViews"][indices["bufferView"].get<std::size_t>()];
      const std::size_t size = indices["componentType"] == 5123 ? 2 : 4;
      const auto count = indices["count"].get<std::size_t>();
      ASSERT_EQ(count * size, view["byteLength"].get<std::size_t>());
      for (std::size_t i = 0; i < count; ++i) {
        std::uint32_t index = 0;
        std::memcpy(&index, glb.binary.data() + view["byteOffset"].get<std::size_t>() + i * size,
                    size);
        ASSERT_LT(index, vertices);
      }
      ASSERT_LT(primitive["material"].get<int>(), kMaterialCount);
    }
  }
  // Furniture shares meshes; something emits; pendants shine.
  std::map<std::size_t, int> uses;
  int lights = 0;
  std::set<std::string> names;
  for (const json& node : document["nodes"]) {
    if (node.contains("mesh")) ++uses[node["mesh"].get<std::size_t>()];
    if (node.contains("extensions")) ++lights;
    EXPECT_TRUE(names.insert(node["name"].get<std::string>()).second) << node["name"];
  }
  EXPECT_GT(std::max_element(uses.begin(), uses.end(),
                             [](const auto& a, const auto& b) { return a.second < b.second; })
                ->second,
            3);
  EXPECT_EQ(uses.size(), document["meshes"].size());
  EXPECT_GE(lights, 1);
}

TEST(Building, ShellsOfAllSpacesCloseTheSolid) {
  for (const int rooms : {1, 2, 7, 40}) {
    const Building building = make_building(rooms, Random(9));
    ASSERT_EQ(building.shells.size(), building.spaces.size() + 1);
    // The walls' solid is bounded by the faces of all spaces and of the outside: each edge is
    // walked as often one way as the other, and no face appears twice.
    using Key = std::array<float, 3>;
    std::map<std::pair<Key, Key>, int> balance;
    std::set<std::array<Key, 3>> faces;
    double volume = 0;
    for (const Model& shell : building.shells) {
      for (const Part& part : shell.parts) {
        const Surface& s = part.surface;
        for (std::size_t i = 0; i < s.indices.size(); i += 3) {
          std::array<Key, 3> corners;
          std::array<Vec3d, 3> points;
          for (std::size_t k = 0; k < 3; ++k) {
            const Vec3f& p = s.positions[s.indices[i + k]];
            corners[k] = {p.x, p.y, p.z};
            points[k] = to_double(p);
          }
          volume += dot(points[0], cross(points[1], points[2])) / 6;
          for (std::size_t k = 0; k < 3; ++k) {
            ++balance[{corners[k], corners[(k + 1) % 3]}];
            --balance[{corners[(k + 1) % 3], corners[k]}];
          }
          std::sort(corners.begin(), corners.end());
          EXPECT_TRUE(faces.insert(corners).second) << "two faces coincide";
        }
      }
    }
    for (const auto& [edge, count] : balance) ASSERT_EQ(count, 0);
    // Solid = whole block less the air of rooms and corridors, doors and windows.
    Aabbd whole;
    double air = 0;
    for (const Space& space : building.spaces) {
      const Vec3d e = space.box.extent();
      air += e.x * e.y * e.z;
    }
    for (const Part& part : building.shells.back().parts) {
      for (const Vec3f& p : part.surface.positions) whole.add(to_double(p));
    }
    const Vec3d e = whole.extent();
    EXPECT_GT(volume, 0);
    EXPECT_LT(volume, e.x * e.y * e.z - air);
    EXPECT_GT(volume, 0.9 * (e.x * e.y * e.z - air));  // openings are a few per cent of the walls
  }
}

}  // namespace
}  // namespace lightbatch::generate
