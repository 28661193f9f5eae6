#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "core/scene_out/vertex_light.h"
#include "tests/unit/scene_out/files.h"

namespace lightbatch::scene_out {
namespace {

using testing::FileBuilder;
using testing::Json;
using testing::load;
using testing::Loaded;

FileBuilder floor_file(bool textured) {
  FileBuilder file;
  file.json["materials"] = {
      {{"name", "floor"}, {"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.25, 1, 1}}}}}};
  if (textured) {
    file.json["images"] = {
        {{"uri",
          "data:image/"
          "png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+"
          "M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="}}};
    file.json["textures"] = {{{"source", 0}}};
    file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  }
  Json cube = file.cube();
  cube["material"] = 0;
  file.node({{"mesh", file.mesh({cube})}, {"scale", {4, 0.1, 4}}});
  file.node({{"mesh", 0}, {"scale", {4, 0.1, 4}}, {"translation", {6, 0, 0}}});
  return file;
}

batches::BatchPlan plan_for(const Loaded& in) {
  batches::BatchOptions options;
  options.traits = describe_objects(in.document, in.scene, nullptr);
  options.page_of_triangle.assign(in.scene.triangles.size(), 0);
  options.max_growth = 3;
  return *batches::plan(in.scene, testing::hierarchy_of(in.scene),
                        batches::Viewpoints(in.scene, {}), options);
}

/// A step of light across the floors at world x = 2.
WriteOptions step_of_light(const Loaded& in) {
  WriteOptions options;
  options.carrier = Carrier::kPortable;
  options.exposure = 0.001;
  options.irradiance = [&in](std::uint32_t t, float u, float v) {
    const auto c = in.scene.corners(t);
    const Vec3f p = c[0] * (1 - u - v) + c[1] * u + c[2] * v;
    const double x = static_cast<double>(p.x) + in.scene.origin.x;
    return x < 2 ? Rgb{1000, 1000, 1000} : Rgb{100, 100, 100};
  };
  return options;
}

TEST(Portable, FeaturesAreNotMixed) {
  FileBuilder file = floor_file(false);
  std::vector<float> ids(24);
  for (std::size_t v = 0; v < ids.size(); ++v) ids[v] = 10.0f * static_cast<float>(v % 4);
  Json& primitive = file.json["meshes"][0]["primitives"][0];
  primitive["attributes"]["_FEATURE_ID_0"] = file.accessor(ids, 5126, "SCALAR");
  primitive["extensions"]["EXT_mesh_features"]["featureIds"] = {
      {{"featureCount", 4}, {"attribute", 0}}};
  file.json["extensionsUsed"] = {"EXT_mesh_features"};
  const Loaded in = load(file.glb());
  const auto glb =
      *write_scene(in.document, in.scene, nullptr, nullptr, nullptr, step_of_light(in));
  const gltf::Document out = testing::read(glb);
  std::size_t vertices = 0;
  for (const Json& mesh : out.json["meshes"])
    for (const Json& p : mesh["primitives"]) {
      EXPECT_EQ(p["extensions"], primitive["extensions"]);
      const auto values = *gltf::read_values(out, p["attributes"]["_FEATURE_ID_0"]);
      for (const float id : values.data) {
        EXPECT_EQ(std::remainder(id, 10.0f), 0);
        ++vertices;
      }
    }
  EXPECT_GT(vertices, 2 * ids.size());  // subdivided
}

TEST(Portable, ColoursAreLuminanceTimesExposure) {
  for (const bool batches : {true, false}) {
    const Loaded in = load(floor_file(false).glb());
    const auto plan = plan_for(in);
    const auto glb = *write_scene(in.document, in.scene, batches ? &plan : nullptr, nullptr,
                                  nullptr, step_of_light(in));
    const gltf::Document out = testing::read(glb);
    EXPECT_EQ(out.json["scenes"][0]["extras"]["lightbatch"]["exposure"], 0.001);
    std::set<int> greens;
    for (const Json& mesh : out.json["meshes"])
      for (const Json& p : mesh["primitives"]) {
        const Json& material = out.json["materials"][p["material"].get<std::size_t>()];
        EXPECT_TRUE(material["extensions"].contains("KHR_materials_unlit"));
        EXPECT_EQ(material["pbrMetallicRoughness"]["baseColorFactor"], Json::array({1, 1, 1, 1}));
        const auto colour = *gltf::read_values(out, p["attributes"]["COLOR_0"]);
        for (std::size_t i = 0; i < colour.data.size(); i += 4) {
          EXPECT_NEAR(colour.data[i], 2 * colour.data[i + 1], 3e-5);
          greens.insert(static_cast<int>(std::lround(colour.data[i + 1] * 1e4f)));
        }
      }
    // green = 0.25 * E / pi * exposure: 0.0796 and 0.0080.
    EXPECT_EQ(greens, (std::set<int>{80, 796}));
  }
}

/// Emission is read at points, subdivides where it changes, and COLOR_0 of the source does not
/// multiply it.
TEST(Portable, EmissionIsAddedPointByPoint) {
  FileBuilder file = floor_file(false);
  Json& cube = file.json["meshes"][0]["primitives"][0];
  const auto corners =
      file.json["accessors"][cube["attributes"]["POSITION"].get<std::size_t>()]["count"];
  cube["attributes"]["COLOR_0"] =
      file.accessor(std::vector<float>(3 * corners.get<std::size_t>(), 0.5f), 5126, "VEC3", 3);
  const Loaded in = load(file.glb());
  WriteOptions options = step_of_light(in);
  options.irradiance = [](std::uint32_t, float, float) { return Rgb::grey(1000); };
  options.emission = [&in](std::uint32_t t, float u, float v) {
    const auto c = in.scene.corners(t);
    const Vec3f p = c[0] * (1 - u - v) + c[1] * u + c[2] * v;
    return Rgb::grey(static_cast<double>(p.x) + in.scene.origin.x < 1 ? 0.0f : 400.0f);
  };
  const auto out =
      testing::read(*write_scene(in.document, in.scene, nullptr, nullptr, nullptr, options));
  std::set<int> greens;
  for (const Json& mesh : out.json["meshes"])
    for (const Json& p : mesh["primitives"]) {
      const auto colour = *gltf::read_values(out, p["attributes"]["COLOR_0"]);
      for (std::size_t i = 0; i < colour.data.size(); i += 4)
        greens.insert(static_cast<int>(std::lround(colour.data[i + 1] * 1e3f)));
    }
  // green = 0.5 * 0.25 * E / pi * exposure = 0.040, and 0.4 more where it emits.
  EXPECT_EQ(greens, (std::set<int>{40, 440}));
}

TEST(Portable, TexturedMaterialsKeepTheirTextureAndFactor) {
  const Loaded in = load(floor_file(true).glb());
  const auto plan = plan_for(in);
  const auto out = testing::read(
      *write_scene(in.document, in.scene, &plan, nullptr, nullptr, step_of_light(in)));
  const Json& base = out.json["materials"][0]["pbrMetallicRoughness"];
  EXPECT_EQ(base["baseColorFactor"], Json::array({0.5, 0.25, 1, 1}));
  EXPECT_TRUE(base.contains("baseColorTexture"));
}

/// Every edge of the subdivided mesh inside a face is shared by two triangles: no gaps.
TEST(Portable, SubdivisionIsConforming) {
  const Loaded in = load(floor_file(false).glb());
  const WriteOptions options = step_of_light(in);
  Writer writer(in.document, in.scene, nullptr, options);
  std::vector<std::uint32_t> triangles;
  for (std::uint32_t t = 0; t < 12; ++t) triangles.push_back(t);
  const LitTriangles lit = subdivide(writer, triangles, 0.001);
  EXPECT_GT(lit.corners.size(), 200u);
  std::map<std::array<float, 6>, int> edges;
  double area = 0;
  for (std::size_t i = 0; i < lit.corners.size(); i += 3) {
    Vec3f p[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const LightPoint& at = lit.corners[i + k];
      const auto c = in.scene.corners(at.triangle);
      p[k] = c[0] * (1 - at.u - at.v) + c[1] * at.u + c[2] * at.v;
    }
    area += 0.5 * static_cast<double>(length(cross(p[1] - p[0], p[2] - p[0])));
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3f &a = p[k], &b = p[(k + 1) % 3];
      ++edges[{a.x, a.y, a.z, b.x, b.y, b.z}];
    }
  }
  // A closed box: each directed edge once, and its opposite too.
  for (const auto& [e, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ(edges.count({e[3], e[4], e[5], e[0], e[1], e[2]}), 1u);
  }
  EXPECT_NEAR(area, 2 * 16 + 4 * 0.4, 1e-4);
}

TEST(Portable, ExposureHoldsNearlyAllOfTheLight) {
  const Loaded in = load(floor_file(false).glb());
  WriteOptions options = step_of_light(in);
  options.exposure = 0;
  // The brightest lit surface gets luminance 1000 / pi.
  EXPECT_NEAR(choose_exposure(in.scene, options), std::numbers::pi / 1000, 1e-9);
}

TEST(Portable, UnlitTrianglesStayAsTheyWere) {
  const Loaded in = load(floor_file(false).glb());
  WriteOptions options = step_of_light(in);
  options.lit.assign(in.scene.triangles.size(), 0);
  const auto out =
      testing::read(*write_scene(in.document, in.scene, nullptr, nullptr, nullptr, options));
  EXPECT_EQ(out.json["materials"], in.document.json["materials"]);
  EXPECT_EQ(out.json["meshes"], in.document.json["meshes"]);
}

}  // namespace
}  // namespace lightbatch::scene_out
