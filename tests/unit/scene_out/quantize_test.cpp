#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/unit/scene_out/files.h"

namespace lightbatch::scene_out {
namespace {

using testing::FileBuilder;
using testing::Json;
using testing::load;
using testing::Loaded;
using testing::world_triangles;
using testing::write;
using testing::Written;

constexpr int kShort = 5122, kUnsignedShort = 5123, kFloat = 5126;

WriteOptions quantized(Quantization quantization) {
  WriteOptions options;
  options.quantization = quantization;
  return options;
}

FileBuilder turned_cubes(int n, double size) {
  FileBuilder file;
  for (int i = 0; i < n * n; ++i)
    file.node({{"mesh", file.mesh({file.cube()})},
               {"translation", {3 * size * (i % n), 1e4 * size, 3 * size * (i / n)}},
               {"rotation", {0, 0.38268343, 0, 0.92387953}},
               {"scale", {size, size, size}}});
  return file;
}

/// Component types of an attribute over all primitives of batches and cells.
std::vector<int> component_types(const Json& json, const char* attribute) {
  std::vector<int> types;
  for (const Json& node : json["nodes"]) {
    if (!node.contains("extras") || !node.contains("mesh")) continue;
    for (const Json& primitive : json["meshes"][node["mesh"].get<std::size_t>()]["primitives"])
      types.push_back(json["accessors"][primitive["attributes"][attribute].get<std::size_t>()]
                          ["componentType"]);
  }
  return types;
}

bool is_listed(const Json& json, const char* key) {
  return json.contains(key) &&
         std::find(json[key].begin(), json[key].end(), "KHR_mesh_quantization") != json[key].end();
}

TEST(Quantize, OnRequestVerticesMoveNoFartherThanSaid) {
  for (const double size : {1.0, 3e-4, 700.0}) {
    const Loaded in = load(turned_cubes(8, size).glb());
    batches::BatchOptions options;
    options.max_vertices = 200;
    const Written plain = write(in, true, nullptr, options);
    const Written out = write(in, true, nullptr, options, quantized(Quantization::kAll));
    EXPECT_LT(out.glb.size(), plain.glb.size());
    EXPECT_EQ(plain.facts.quantized, 0u);
    const Json json = testing::read(out.glb).json;
    const auto types = component_types(json, "POSITION");
    EXPECT_EQ(out.facts.quantized, types.size());
    EXPECT_EQ(std::count(types.begin(), types.end(), kShort),
              static_cast<std::ptrdiff_t>(types.size()));
    EXPECT_EQ(component_types(json, "NORMAL").front(), kShort);
    EXPECT_EQ(component_types(json, "TEXCOORD_0").front(), kUnsignedShort);
    EXPECT_TRUE(is_listed(json, "extensionsUsed") && is_listed(json, "extensionsRequired"));
    // A grid of 2^-16 of the largest batch at the coarsest; float itself is no exacter far away.
    const double said = out.facts.position_error;
    EXPECT_GT(said, 0);
    EXPECT_LT(said, 24 * size / 32767);
    const double moved =
        testing::largest_distance(world_triangles(in), world_triangles(load(out.glb)), size);
    EXPECT_LT(moved, said + 2e-3 * size);
  }
}

/// One wall of squares, each an object, cut into batches with frames of their own.
TEST(Quantize, WhatMetStillMeets) {
  FileBuilder file;
  constexpr int kSide = 64;
  for (int i = 0; i < kSide * kSide; ++i) {
    const auto x = 0.1f * static_cast<float>(i % kSide), z = 0.1f * static_cast<float>(i / kSide);
    const float right = 0.1f * static_cast<float>(i % kSide + 1),
                far = 0.1f * static_cast<float>(i / kSide + 1);
    const Json square{
        {"attributes",
         {{"POSITION", file.positions({x, 0, z, x, 0, far, right, 0, far, right, 0, z})}}},
        {"indices", file.accessor(std::vector<std::uint16_t>{0, 1, 2, 0, 2, 3}, 5123, "SCALAR")}};
    file.node({{"mesh", file.mesh({square})}});
  }
  const Loaded in = load(file.glb());
  const Written out = write(in, true, nullptr, {}, quantized(Quantization::kAll));
  EXPECT_GT(out.plan.batches.size(), 1u);
  const Loaded again = load(out.glb);
  std::map<std::array<long, 3>, Vec3f> corners;  // by place in millimetres
  for (std::uint32_t t = 0; t < again.scene.triangles.size(); ++t)
    for (const Vec3f& p : again.scene.corners(t)) {
      const Vec3d place = again.scene.origin + to_double(p);
      const std::array<long, 3> key{std::lround(place.x * 1000 / 50), std::lround(place.y),
                                    std::lround(place.z * 1000 / 50)};
      const auto [it, fresh] = corners.try_emplace(key, p);
      EXPECT_LT(length(it->second - p), 1e-6f);
    }
  EXPECT_EQ(corners.size(), static_cast<std::size_t>((kSide + 1) * (kSide + 1)));
}

/// Cubes of shorts, normalised, under a scale.
FileBuilder cubes_of_shorts(int n, double scale, std::int16_t largest) {
  FileBuilder file;
  for (int i = 0; i < n; ++i) {
    Json cube = file.cube();
    std::vector<std::int16_t> p;
    for (int axis = 0; axis < 3; ++axis)
      for (int side = 0; side < 2; ++side)
        for (int k = 0; k < 4; ++k) {
          std::array<std::int16_t, 4> at{};
          at[static_cast<std::size_t>(axis)] = side != 0 ? largest : std::int16_t{0};
          at[static_cast<std::size_t>((axis + 1) % 3)] =
              k == 1 || k == 2 ? largest : std::int16_t{0};
          at[static_cast<std::size_t>((axis + 2) % 3)] = k >= 2 ? largest : std::int16_t{0};
          p.insert(p.end(), at.begin(), at.end());
        }
    const std::uint32_t a = file.accessor(p, kShort, "VEC4", true);
    file.json["accessors"][a].update(
        {{"type", "VEC3"}, {"min", {0, 0, 0}}, {"max", {largest, largest, largest}}});
    file.json["bufferViews"].back()["byteStride"] = 8;
    cube["attributes"]["POSITION"] = a;
    file.node({{"mesh", file.mesh({cube})},
               {"translation", {2.5 * i, 0, 0}},
               {"scale", {scale, scale, scale}}});
  }
  file.json["extensionsUsed"] = file.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  return file;
}

TEST(Quantize, IntegersStayWhereTheirOwnGridWasNoFiner) {
  // A grid as fine as that of the batch; one 16 times finer, of 1/16 of its range.
  for (const auto& [scale, fine] : {std::pair{8.0, false}, {0.5, true}}) {
    const auto largest = static_cast<std::int16_t>(fine ? 32767 : 2048);
    const Loaded in = load(cubes_of_shorts(6, scale, largest).glb());
    const Written out = write(in, true);
    const auto types = component_types(testing::read(out.glb).json, "POSITION");
    ASSERT_FALSE(types.empty());
    EXPECT_EQ(types.front(), fine ? kFloat : kShort);
    EXPECT_EQ(component_types(testing::read(out.glb).json, "NORMAL").front(), kFloat);
    EXPECT_LE(out.facts.position_error, fine ? 0 : scale / 32767);
    EXPECT_LT(testing::largest_distance(world_triangles(in), world_triangles(load(out.glb)), 0.1),
              1e-3);
    const Written floats = write(in, true, nullptr, {}, quantized(Quantization::kOff));
    EXPECT_EQ(component_types(testing::read(floats.glb).json, "POSITION").front(), kFloat);
  }
}

/// The step would scale it.
TEST(Quantize, VolumesOfSomeThicknessKeepTheirCoordinates) {
  for (const double thickness : {0.0, 0.2}) {
    FileBuilder file = turned_cubes(3, 1);
    file.json["materials"] = {
        {{"extensions", {{"KHR_materials_volume", {{"thicknessFactor", thickness}}}}}}};
    file.json["extensionsUsed"] = {"KHR_materials_volume"};
    for (Json& mesh : file.json["meshes"]) mesh["primitives"][0]["material"] = 0;
    const Written out = write(load(file.glb()), true, nullptr, {}, quantized(Quantization::kAll));
    const auto types = component_types(testing::read(out.glb).json, "POSITION");
    ASSERT_FALSE(types.empty());
    EXPECT_EQ(types.front(), thickness > 0 ? kFloat : kShort);
  }
}

TEST(Quantize, PlacementsOfSharedMeshesHoldTheGrid) {
  for (const bool shorts : {false, true}) {
    FileBuilder file = shorts ? cubes_of_shorts(1, 1, 32767) : turned_cubes(1, 1);
    for (int i = 1; i < 60; ++i) {
      const double angle = 0.1 * i;
      file.node({{"mesh", 0},
                 {"translation", {40 * (i % 8), i % 3, 40 * (i / 8)}},
                 {"rotation", {0, std::sin(angle), 0, std::cos(angle)}},
                 {"scale", {2, 1, 1.5}}});
    }
    const Loaded in = load(file.glb());
    batches::BatchOptions options;
    options.max_growth = 1;
    options.max_vertices = 10;
    for (const Quantization q : {Quantization::kAsInput, Quantization::kAll}) {
      const Written out = write(in, true, nullptr, options, quantized(q));
      ASSERT_FALSE(out.plan.cells.empty());
      const bool whole = shorts || q == Quantization::kAll;
      EXPECT_EQ(component_types(testing::read(out.glb).json, "POSITION").front(),
                whole ? kShort : kFloat);
      EXPECT_EQ(out.facts.quantized > 0, !shorts && q == Quantization::kAll);
      EXPECT_LT(testing::largest_distance(world_triangles(in), world_triangles(load(out.glb)), 1),
                1e-4);
    }
  }
}

}  // namespace
}  // namespace lightbatch::scene_out
