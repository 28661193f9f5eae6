#pragma once

#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include "core/gltf/accessor.h"
#include "core/gltf/document.h"
#include "core/gltf/glb_writer.h"
#include "core/hierarchy/hierarchy.h"
#include "core/scene_in/read_scene.h"
#include "core/scene_out/write_scene.h"

namespace lightbatch::scene_out::testing {

using gltf::Json;

/// A glTF file made by hand.
class FileBuilder {
 public:
  FileBuilder() {
    json = {{"asset", {{"version", "2.0"}}},
            {"scene", 0},
            {"scenes", {{{"nodes", Json::array()}}}},
            {"nodes", Json::array()},
            {"meshes", Json::array()},
            {"accessors", Json::array()},
            {"bufferViews", Json::array()},
            {"buffers", {{{"byteLength", 0}}}}};
  }

  template <typename T>
  std::uint32_t accessor(const std::vector<T>& values, int component_type, const char* type,
                         bool normalized = false) {
    binary_.resize((binary_.size() + 3) / 4 * 4);
    const std::size_t bytes = values.size() * sizeof(T);
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", bytes}});
    const auto* raw = reinterpret_cast<const std::byte*>(values.data());
    binary_.insert(binary_.end(), raw, raw + bytes);
    const std::string kind = type;
    const std::size_t components = kind == "SCALAR" ? 1
                                   : kind == "VEC2" ? 2
                                   : kind == "VEC3" ? 3
                                   : kind == "VEC4" ? 4
                                                    : 16;
    Json a{{"bufferView", json["bufferViews"].size() - 1},
           {"componentType", component_type},
           {"count", values.size() / components},
           {"type", type}};
    if (normalized) a["normalized"] = true;
    json["accessors"].push_back(std::move(a));
    return static_cast<std::uint32_t>(json["accessors"].size() - 1);
  }
  std::uint32_t positions(const std::vector<float>& values) {
    const std::uint32_t a = accessor(values, 5126, "VEC3");
    std::array<float, 3> low{1e30f, 1e30f, 1e30f}, high{-1e30f, -1e30f, -1e30f};
    for (std::size_t i = 0; i < values.size(); ++i) {
      low[i % 3] = std::min(low[i % 3], values[i]);
      high[i % 3] = std::max(high[i % 3], values[i]);
    }
    json["accessors"][a]["min"] = low;
    json["accessors"][a]["max"] = high;
    return a;
  }
  /// A unit cube's primitive: 24 vertices with NORMAL and TEXCOORD_0, 12 triangles.
  Json cube() {
    std::vector<float> p, n, uv;
    std::vector<std::uint16_t> index;
    for (int axis = 0; axis < 3; ++axis)
      for (int side = 0; side < 2; ++side) {
        const auto base = static_cast<std::uint16_t>(p.size() / 3);
        for (int k = 0; k < 4; ++k) {
          const float u = k == 1 || k == 2 ? 1.0f : 0.0f, v = k >= 2 ? 1.0f : 0.0f;
          std::array<float, 3> at{}, normal{};
          at[static_cast<std::size_t>(axis)] = side != 0 ? 1.0f : 0.0f;
          at[static_cast<std::size_t>((axis + 1) % 3)] = u;
          at[static_cast<std::size_t>((axis + 2) % 3)] = v;
          normal[static_cast<std::size_t>(axis)] = side != 0 ? 1.0f : -1.0f;
          p.insert(p.end(), at.begin(), at.end());
          n.insert(n.end(), normal.begin(), normal.end());
          uv.insert(uv.end(), {u, v});
        }
        for (const int k : side != 0 ? std::array{0, 1, 2, 0, 2, 3} : std::array{0, 2, 1, 0, 3, 2})
          index.push_back(static_cast<std::uint16_t>(base + k));
      }
    return {{"attributes",
             {{"POSITION", positions(p)},
              {"NORMAL", accessor(n, 5126, "VEC3")},
              {"TEXCOORD_0", accessor(uv, 5126, "VEC2")}}},
            {"indices", accessor(index, 5123, "SCALAR")}};
  }
  std::uint32_t mesh(std::vector<Json> primitives) {
    json["meshes"].push_back({{"primitives", std::move(primitives)}});
    return static_cast<std::uint32_t>(json["meshes"].size() - 1);
  }
  /// A node of the default scene.
  std::uint32_t node(Json node) {
    json["nodes"].push_back(std::move(node));
    const auto index = static_cast<std::uint32_t>(json["nodes"].size() - 1);
    json["scenes"][0]["nodes"].push_back(index);
    return index;
  }
  /// Moves a node from place to place (x, y, z each), one a second.
  void animate(std::uint32_t node, const std::vector<float>& places) {
    std::vector<float> seconds(places.size() / 3);
    std::iota(seconds.begin(), seconds.end(), 0.0f);
    const std::uint32_t times = accessor(seconds, 5126, "SCALAR");
    json["accessors"][times].update(Json{{"min", {seconds.front()}}, {"max", {seconds.back()}}});
    const std::uint32_t ways = accessor(places, 5126, "VEC3");
    Json animation;
    animation["samplers"] = {{{"input", times}, {"output", ways}}};
    animation["channels"] = {
        {{"sampler", 0}, {"target", {{"node", node}, {"path", "translation"}}}}};
    json["animations"].push_back(animation);
  }
  Bytes glb() const { return std::move(gltf::write_glb(json, binary_)).value(); }

  Json json;

 private:
  Bytes binary_;
};

inline gltf::Document read(const Bytes& glb) {
  static int number = 0;
  const auto path =
      std::filesystem::temp_directory_path() /
      ("scene_out_test_" + std::to_string(getpid()) + "_" + std::to_string(number++) + ".glb");
  LB_CHECK(write_file(path, glb).ok(), "a temporary file");
  auto document = gltf::read_document({{"test.glb", path}}, "test.glb");
  std::filesystem::remove(path);
  LB_CHECK(document.ok(), document.status().to_string().c_str());
  return std::move(document).value();
}

inline hierarchy::Hierarchy hierarchy_of(const scene::Scene& scene) {
  std::vector<Aabb> boxes(scene.triangles.size());
  for (std::uint32_t t = 0; t < boxes.size(); ++t)
    for (const Vec3f& p : scene.corners(t)) boxes[t].add(p);
  return hierarchy::build(boxes);
}

/// A file with its scene, and what comes out of it.
struct Loaded {
  gltf::Document document;
  scene::Scene scene;
};
inline Loaded load(const Bytes& glb) {
  Loaded loaded{read(glb), {}};
  auto scene = scene_in::read_scene(loaded.document);
  LB_CHECK(scene.ok(), scene.status().to_string().c_str());
  loaded.scene = std::move(scene).value();
  return loaded;
}

/// Every triangle gets its own square of a page: enough to test what is written.
inline atlas::Layout simple_layout(const scene::Scene& scene, int pages = 1) {
  atlas::Layout layout;
  for (int p = 0; p < pages; ++p) layout.pages.push_back({64, 32});
  layout.uv.resize(scene.triangles.size());
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
    atlas::Chart chart;
    chart.page = t % static_cast<std::uint32_t>(pages);
    layout.chart_of.push_back(t);
    layout.charts.push_back(chart);
    const float x = static_cast<float>(t % 60), y = static_cast<float>(t / 60 % 30);
    layout.uv[t] = {Vec2f{x, y}, {x + 0.5f, y}, {x, y + 0.5f}};
  }
  return layout;
}
inline LightmapImages images_for(const atlas::Layout& layout) {
  LightmapImages images;
  for (std::size_t p = 0; p < layout.pages.size(); ++p) {
    // Signature of a PNG file: contents do not matter here.
    Bytes png;
    for (const int b : {0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a})
      png.push_back(static_cast<std::byte>(b));
    images.png.push_back(std::move(png));
    images.intensity.push_back(2.5f + static_cast<float>(p));
  }
  return images;
}

struct Written {
  Bytes glb;
  batches::BatchPlan plan;
  WriteFacts facts;
};
inline Written write(const Loaded& in, bool with_batches, const atlas::Layout* layout = nullptr,
                     batches::BatchOptions options = {}, WriteOptions write_options = {}) {
  Written result;
  options.traits = describe_objects(in.document, in.scene, layout);
  if (layout != nullptr)
    for (std::uint32_t t = 0; t < in.scene.triangles.size(); ++t)
      options.page_of_triangle.push_back(layout->chart_of[t] == scene::kNone
                                             ? scene::kNone
                                             : layout->charts[layout->chart_of[t]].page);
  if (with_batches) {
    auto plan =
        batches::plan(in.scene, hierarchy_of(in.scene), batches::Viewpoints(in.scene, {}), options);
    LB_CHECK(plan.ok(), plan.status().to_string().c_str());
    result.plan = std::move(plan).value();
  }
  LightmapImages images;
  if (layout != nullptr) images = images_for(*layout);
  auto bytes = write_scene(in.document, in.scene, with_batches ? &result.plan : nullptr, layout,
                           layout != nullptr ? &images : nullptr, write_options, &result.facts);
  LB_CHECK(bytes.ok(), bytes.status().to_string().c_str());
  result.glb = std::move(bytes).value();
  return result;
}

/// World triangles for comparison: corners from the lowest on, so that winding stays and the start
/// does not matter.
struct WorldTriangle {
  std::array<Vec3d, 3> corner;
  std::string material;  // what it looks like: base colour with COLOR_0, texture, emission...
};
std::vector<WorldTriangle> world_triangles(const Loaded& file);

/// The largest distance between a triangle of a and its partner in b (same material and winding);
/// infinite when some have no partner within `reach`.
double largest_distance(const std::vector<WorldTriangle>& a, const std::vector<WorldTriangle>& b,
                        double reach);

}  // namespace lightbatch::scene_out::testing
