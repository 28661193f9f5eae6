#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/parallel.h"
#include "tests/unit/scene_in/scene_builder.h"

namespace lightbatch::scene_in {
namespace {

constexpr double kHalf = 0.70710678118654752;  // sin 45 degrees

TEST(Geometry, SquareComesThroughExactly) {
  SceneBuilder builder;
  builder.square();
  const scene::Scene scene = read(builder);
  ASSERT_EQ(scene.triangles.size(), 2u);
  EXPECT_EQ(scene.positions.size(), 4u);  // shared corners stay shared
  ASSERT_EQ(scene.objects.size(), 1u);
  EXPECT_EQ(scene.objects[0].name, "node 0");
  EXPECT_EQ(scene.objects[0].triangle_count, 2u);
  ASSERT_EQ(scene.materials.size(), 1u);
  EXPECT_EQ(scene.materials[0].gltf_index, scene::kNone);
  EXPECT_EQ(world_corner(scene, 0, 1), (Vec3d{1, 0, 0}));
  EXPECT_EQ(world_normal(scene, 0), (Vec3d{0, 0, 1}));
  EXPECT_EQ(scene.triangles[1].source, 1u);
  EXPECT_TRUE(scene.uv0.empty());
}

TEST(Geometry, TransformsCompose) {
  SceneBuilder builder;
  builder.square();
  // Parent: a quarter turn about z, then moved; child: scaled.
  builder.json["nodes"] = {
      {{"translation", {10, 0, 0}}, {"rotation", {0, 0, kHalf, kHalf}}, {"children", {1}}},
      {{"mesh", 0}, {"scale", {2, 3, 1}}, {"name", "child"}}};
  const scene::Scene scene = read(builder);
  ASSERT_EQ(scene.triangles.size(), 2u);
  EXPECT_EQ(scene.objects[0].name, "child");
  // Corner (1, 1, 0) -> (2, 3, 0) -> (-3, 2, 0) -> (7, 2, 0).
  const Vec3d corner = world_corner(scene, 0, 2);
  EXPECT_NEAR(corner.x, 7, 1e-6);
  EXPECT_NEAR(corner.y, 2, 1e-6);
  EXPECT_NEAR(corner.z, 0, 1e-6);
  EXPECT_NEAR(total_area(scene), 6, 1e-5);
}

TEST(Geometry, MatrixEqualsItsParts) {
  SceneBuilder builder;
  builder.square();
  builder.json["nodes"][0] = {{"mesh", 0},
                              {"matrix", {0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1}}};
  const scene::Scene scene = read(builder);
  EXPECT_EQ(world_corner(scene, 0, 1), (Vec3d{5, 8, 7}));
  EXPECT_EQ(world_corner(scene, 0, 2), (Vec3d{2, 8, 7}));
  EXPECT_EQ(scene.objects[0].to_world.point({1, 1, 0}), (Vec3d{2, 8, 7}));
}

TEST(Geometry, MirroringKeepsTheFrontInFront) {
  SceneBuilder builder;
  builder.square();
  builder.json["nodes"][0]["scale"] = {-1, 1, 1};
  const scene::Scene scene = read(builder);
  ASSERT_EQ(scene.triangles.size(), 2u);
  EXPECT_TRUE(scene.objects[0].mirrored);
  EXPECT_EQ(world_normal(scene, 0), (Vec3d{0, 0, 1}));
  EXPECT_EQ(world_normal(scene, 1), (Vec3d{0, 0, 1}));
}

TEST(Geometry, FarFromTheOriginNothingIsLost) {
  SceneBuilder builder;
  builder.square();
  builder.json["nodes"][0]["translation"] = {1e7, -2e7, 3e6};
  builder.json["nodes"][0]["scale"] = {1e-3, 1e-3, 1e-3};
  const scene::Scene scene = read(builder);
  ASSERT_EQ(scene.triangles.size(), 2u);
  // Float coordinates at 1e7 have steps of 1; relative to the origin the millimetre survives.
  double area = 0;
  for (std::uint32_t t = 0; t < 2; ++t) {
    const auto c = scene.corners(t);
    area += 0.5 * length(cross(to_double(c[1] - c[0]), to_double(c[2] - c[0])));
  }
  EXPECT_NEAR(area, 1e-6, 1e-12);
  EXPECT_NEAR(world_corner(scene, 0, 1).x, 1e7 + 1e-3, 1e-9);
}

TEST(Geometry, StripsFansAndLists) {
  const std::vector<float> strip = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0};
  SceneBuilder builder;
  builder.mesh(strip, {});
  builder.primitive()["mode"] = 5;
  scene::Scene scene = read(builder);
  ASSERT_EQ(scene.triangles.size(), 3u);
  for (std::uint32_t t = 0; t < 3; ++t) {
    EXPECT_EQ(world_normal(scene, t), (Vec3d{0, 0, 1})) << t;
    EXPECT_EQ(scene.triangles[t].source, t);
  }
  builder = SceneBuilder();
  builder.mesh({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, {0, 1, 2, 3});
  builder.primitive()["mode"] = 6;
  scene = read(builder);
  ASSERT_EQ(scene.triangles.size(), 2u);
  EXPECT_EQ(world_normal(scene, 1), (Vec3d{0, 0, 1}));
  EXPECT_DOUBLE_EQ(total_area(scene), 1);
  // A list of 7 corners has two triangles; the odd one out is ignored.
  builder = SceneBuilder();
  builder.mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 9, 9, 9}, {});
  scene = read(builder);
  EXPECT_EQ(scene.triangles.size(), 2u);
  EXPECT_EQ(scene.positions.size(), 6u);  // the unused vertex is gone
}

TEST(Geometry, TrianglesWithoutAreaAreCounted) {
  SceneBuilder builder;
  builder.mesh({0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0}, {0, 1, 3,    // good
                                                      0, 1, 2,    // collinear
                                                      0, 0, 1,    // two corners the same
                                                      3, 3, 3});  // a point
  const scene::Scene scene = read(builder);
  EXPECT_EQ(scene.triangles.size(), 1u);
  EXPECT_EQ(scene.counts.zero_area_triangles, 3u);
  EXPECT_EQ(scene.triangles[0].source, 0u);
}

// A point, and a line, far away: neither moves the origin nor stretches the box.
TEST(Geometry, TrianglesWithoutAreaDoNotSpoilTheRest) {
  SceneBuilder builder;
  builder.square();
  builder.mesh({0, 0, 0, 1, 2, 3, 2, 4, 6}, {0, 0, 0, 0, 1, 2});
  builder.json["nodes"] = {{{"mesh", 0}, {"translation", {1e6, 0, 4e6}}},
                           {{"mesh", 1}},
                           {{"mesh", 1}, {"translation", {0, -1e200, 0}}}};
  builder.json["scenes"][0]["nodes"] = {0, 1, 2};
  const scene::Scene scene = read(builder);
  EXPECT_EQ(scene.counts.zero_area_triangles, 4u);
  ASSERT_EQ(scene.triangles.size(), 2u);
  EXPECT_EQ(scene.objects.size(), 1u);
  EXPECT_EQ(scene.positions.size(), 4u);
  EXPECT_LT(scene.box.diagonal(), 1.5f);
  EXPECT_EQ(world_corner(scene, 0, 2), (Vec3d{1e6 + 1, 1, 4e6}));
}

// Some of a primitive's vertices go; what belongs to the others stays with them.
TEST(Geometry, VertexColoursStayWithTheirVertices) {
  SceneBuilder builder;
  builder.mesh({9, 9, 9, 0, 0, 0, 7, 7, 7, 1, 0, 0, 0, 1, 0}, {0, 0, 2, 1, 3, 4});
  builder.primitive()["attributes"]["COLOR_0"] = builder.accessor(
      std::vector<float>{0, 0, 0, 0.25f, 0, 0, 0, 0, 0, 0.5f, 0, 0, 0.75f, 0, 0}, "VEC3", 3);
  const scene::Scene scene = read(builder);
  ASSERT_EQ(scene.triangles.size(), 1u);
  ASSERT_EQ(scene.colors.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t v = scene.triangles[0].vertex[k];
    EXPECT_EQ(scene.colors[v].rgb.r, 0.25f + 0.25f * static_cast<float>(k));
  }
  EXPECT_EQ(world_corner(scene, 0, 1), (Vec3d{1, 0, 0}));
}

TEST(Geometry, TooLargeToTellIsRefused) {
  for (const double size : {1e16, 1e170, 1e308}) {
    SceneBuilder builder;
    builder.square();
    builder.json["nodes"][0]["scale"] = {size, size, size};
    const auto document = builder.read();
    ASSERT_TRUE(document.ok());
    EXPECT_EQ(read_scene(*document, {}).status().reason(), "INPUT_MALFORMED") << size;
  }
}

TEST(Geometry, TheNodeThatReachesTooFarIsNamed) {
  SceneBuilder builder;
  builder.square();
  for (int i = 1; i <= 4; ++i) {
    builder.json["nodes"].push_back(
        {{"mesh", 0}, {"translation", {i == 3 ? -1e20 : 1e3 * i, 0, 0}}});
    builder.json["scenes"][0]["nodes"].push_back(i);
  }
  const auto document = builder.read();
  ASSERT_TRUE(document.ok());
  EXPECT_EQ(read_scene(*document, {}).status().place(), "scene.glb#/nodes/3");
}

TEST(Geometry, ObjectsWithNothingLeftAreGone) {
  SceneBuilder builder;
  builder.mesh({0, 0, 0, 1, 0, 0, 2, 0, 0}, {});
  const scene::Scene scene = read(builder);
  EXPECT_TRUE(scene.objects.empty());
  EXPECT_TRUE(scene.triangles.empty());
  EXPECT_EQ(scene.counts.zero_area_triangles, 1u);
}

TEST(Geometry, ZeroScaleDropsTheSubtreeFlatScaleDoesNot) {
  SceneBuilder builder;
  builder.square();
  builder.json["nodes"] = {{{"scale", {0, 0, 0}}, {"children", {2}}},
                           {{"mesh", 0}, {"scale", {1, 1, 0}}},
                           {{"mesh", 0}}};
  builder.json["scenes"][0]["nodes"] = {0, 1};
  const scene::Scene scene = read(builder);
  EXPECT_EQ(scene.triangles.size(), 2u);
  EXPECT_EQ(scene.counts.zero_scale_nodes, 1u);
}

TEST(Geometry, InstancesAreExpanded) {
  SceneBuilder builder;
  builder.square();
  const std::size_t translation = builder.accessor(std::vector<float>{0, 0, 0, 0, 0, 5}, "VEC3", 3);
  const std::size_t rotation = builder.accessor(
      std::vector<float>{0, 0, 0, 1, static_cast<float>(kHalf), 0, 0, static_cast<float>(kHalf)},
      "VEC4", 4);
  const std::size_t scale = builder.accessor(std::vector<float>{1, 1, 1, 2, 2, 2}, "VEC3", 3);
  builder.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", translation}, {"ROTATION", rotation}, {"SCALE", scale}};
  builder.json["nodes"][0]["translation"] = {100, 0, 0};
  builder.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  const scene::Scene scene = read(builder);
  ASSERT_EQ(scene.objects.size(), 2u);
  EXPECT_EQ(scene.objects[1].instance, 1u);
  EXPECT_EQ(scene.objects[0].instance, 0u);
  EXPECT_NEAR(total_area(scene), 1 + 4, 1e-5);
  // Instance 1: (1, 1, 0) doubled, a quarter turn about x, up by 5, then the node: (102, 0, 7).
  const Vec3d corner = world_corner(scene, 2, 2);
  EXPECT_NEAR(corner.x, 102, 1e-5);
  EXPECT_NEAR(corner.y, 0, 1e-5);
  EXPECT_NEAR(corner.z, 7, 1e-5);
}

TEST(Geometry, QuantisedAndSparsePositions) {
  SceneBuilder builder;
  const std::size_t positions =
      builder.accessor(std::vector<std::uint16_t>{0, 0, 0, 0, 65535, 0, 0, 0, 0, 65535, 0, 0},
                       "VEC4", 4);  // 8-byte stride: 3 components and 2 bytes of padding
  Json& accessor = builder.json["accessors"][positions];
  accessor["type"] = "VEC3";
  accessor["normalized"] = true;
  builder.json["bufferViews"][0]["byteStride"] = 8;
  accessor["sparse"] = {
      {"count", 1},
      {"indices",
       {{"bufferView", builder.view(std::vector<std::uint8_t>{1})}, {"componentType", 5121}}},
      {"values", {{"bufferView", builder.view(std::vector<std::uint16_t>{0, 0, 65535})}}}};
  builder.json["meshes"] =
      Json::array({{{"primitives", Json::array({{{"attributes", {{"POSITION", positions}}}}})}}});
  builder.json["extensionsUsed"] = {"KHR_mesh_quantization"};
  builder.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  const scene::Scene scene = read(builder);
  ASSERT_EQ(scene.triangles.size(), 1u);
  EXPECT_EQ(world_corner(scene, 0, 1), (Vec3d{0, 0, 1}));
  EXPECT_EQ(world_corner(scene, 0, 2), (Vec3d{0, 1, 0}));
}

TEST(Geometry, PositionsThatAreNotFiniteAreNamed) {
  SceneBuilder builder;
  builder.mesh({0, 0, 0, std::numeric_limits<float>::infinity(), 0, 0, 0, 1, 0}, {});
  EXPECT_EQ(builder.read().status().place(), "scene.glb#/accessors/0");
}

TEST(Geometry, TransformsThatOverflowAreRefused) {
  SceneBuilder builder;
  builder.square();
  builder.json["nodes"] = {{{"scale", {1e200, 1, 1}}, {"children", {1}}},
                           {{"scale", {1e200, 1, 1}}, {"mesh", 0}}};
  auto document = builder.read();
  ASSERT_TRUE(document.ok());
  EXPECT_EQ(read_scene(*document).status().place(), "scene.glb#/nodes/1");
  builder.json["nodes"] = {{{"scale", {1e30, 1, 1}}, {"mesh", 0}}};
  document = builder.read();
  ASSERT_TRUE(document.ok());
  EXPECT_EQ(read_scene(*document).status().reason(), "INPUT_MALFORMED");
}

TEST(Geometry, BudgetsCountInstances) {
  SceneBuilder builder;
  builder.square();
  builder.json["nodes"] = Json::array();
  Json roots = Json::array();
  for (int i = 0; i < 10; ++i) {
    builder.json["nodes"].push_back({{"mesh", 0}});
    roots.push_back(i);
  }
  builder.json["scenes"][0]["nodes"] = roots;
  EXPECT_EQ(read(builder, {.triangles = 20}).triangles.size(), 20u);
  const auto document = builder.read();
  ASSERT_TRUE(document.ok());
  EXPECT_EQ(read_scene(*document, {.triangles = 19}).status().reason(), "INPUT_OVER_BUDGET");
  EXPECT_EQ(read_scene(*document, {.nodes = 9}).status().reason(), "INPUT_OVER_BUDGET");
}

TEST(Geometry, OnlyTheDefaultSceneIsRead) {
  SceneBuilder builder;
  builder.square();
  builder.json["nodes"].push_back({{"mesh", 0}, {"name", "other"}});
  builder.json["scenes"].push_back({{"nodes", {1}}});
  builder.json["scene"] = 1;
  EXPECT_EQ(read(builder).objects[0].name, "other");
  builder.json.erase("scene");
  EXPECT_EQ(read(builder).objects[0].name, "node 0");
  builder.json.erase("scenes");
  const scene::Scene empty = read(builder);
  EXPECT_TRUE(empty.objects.empty());
  EXPECT_EQ(empty.warnings.size(), 1u);
}

TEST(Geometry, ThreadsDoNotChangeTheResult) {
  SceneBuilder builder;
  std::vector<float> positions;
  std::vector<std::uint16_t> indices;
  for (std::uint16_t i = 0; i < 60'000; ++i) {
    for (const double value : {std::sin(i * 0.1), std::cos(i * 0.37), i * 1e-3}) {
      positions.push_back(static_cast<float>(value));
    }
    indices.push_back(static_cast<std::uint16_t>(i * 7 % 60'000));
  }
  builder.mesh(positions, indices);
  builder.json["nodes"][0]["rotation"] = {0.1, 0.2, 0.3, 0.9};
  const int before = thread_count();
  set_thread_count(1);
  const scene::Scene one = read(builder);
  set_thread_count(4);
  const scene::Scene four = read(builder);
  set_thread_count(before);
  EXPECT_EQ(one.positions, four.positions);
  ASSERT_EQ(one.triangles.size(), four.triangles.size());
  for (std::size_t t = 0; t < one.triangles.size(); ++t) {
    ASSERT_EQ(one.triangles[t].vertex, four.triangles[t].vertex);
  }
}

}  // namespace
}  // namespace lightbatch::scene_in
