#pragma once

#include <cstdint>
#include <vector>

#include "core/hierarchy/hierarchy.h"
#include "core/scene/scene.h"

namespace lightbatch::batches::testing {

/// A scene made by hand: boxes of 12 triangles, each an object.
class SceneBuilder {
 public:
  SceneBuilder() { scene_.materials.resize(1); }

  std::uint32_t add_material(scene::AlphaMode mode = scene::AlphaMode::kOpaque) {
    scene_.materials.emplace_back().alpha_mode = mode;
    return static_cast<std::uint32_t>(scene_.materials.size() - 1);
  }
  /// A box with corners a and b, every face cut into cells x cells quads. Returns the object.
  std::uint32_t add_box(Vec3f a, Vec3f b, std::uint32_t material = 0, std::uint32_t mesh = 0,
                        int cells = 1) {
    return add_object(a, material, mesh, [&] {
      for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side) add_face(a, b, axis, side != 0, cells);
    });
  }
  /// A rectangle across x, to be seen from greater x, or else from less.
  std::uint32_t add_wall(Vec3f a, Vec3f b, bool faces_up, std::uint32_t material) {
    return add_object(a, material, 0, [&] { add_face(a, b, 0, faces_up, 1); });
  }
  scene::Scene take() { return std::move(scene_); }

 private:
  template <typename AddFaces>
  std::uint32_t add_object(Vec3f a, std::uint32_t material, std::uint32_t mesh,
                           const AddFaces& add_faces) {
    scene::Object object;
    object.name = "box";
    object.node = static_cast<std::uint32_t>(scene_.objects.size());
    object.mesh = mesh == 0 ? 1000 + object.node : mesh;
    object.material = material;
    object.first_triangle = static_cast<std::uint32_t>(scene_.triangles.size());
    object.to_world.t = to_double(a);
    add_faces();
    object.triangle_count =
        static_cast<std::uint32_t>(scene_.triangles.size()) - object.first_triangle;
    scene_.objects.push_back(object);
    return static_cast<std::uint32_t>(scene_.objects.size() - 1);
  }
  void add_face(Vec3f a, Vec3f b, int axis, bool upper, int cells) {
    const auto u = static_cast<std::size_t>((axis + 1) % 3),
               v = static_cast<std::size_t>((axis + 2) % 3);
    const auto n = static_cast<std::size_t>(axis);
    const auto base = static_cast<std::uint32_t>(scene_.positions.size());
    const auto row = static_cast<std::uint32_t>(cells + 1);
    for (int j = 0; j <= cells; ++j)
      for (int i = 0; i <= cells; ++i) {
        Vec3f p;
        p[n] = upper ? b[n] : a[n];
        p[u] = a[u] + (b[u] - a[u]) * static_cast<float>(i) / static_cast<float>(cells);
        p[v] = a[v] + (b[v] - a[v]) * static_cast<float>(j) / static_cast<float>(cells);
        scene_.positions.push_back(p);
        scene_.box.add(p);
      }
    const auto object = static_cast<std::uint32_t>(scene_.objects.size());
    for (std::uint32_t j = 0; j + 1 < row; ++j)
      for (std::uint32_t i = 0; i + 1 < row; ++i) {
        const std::uint32_t p = base + j * row + i;
        const std::uint32_t quad[4] = {p, p + 1, p + row + 1, p + row};
        for (const auto& t : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
          scene::Triangle triangle;
          for (std::size_t c = 0; c < 3; ++c) triangle.vertex[c] = quad[t[upper ? c : 2 - c]];
          triangle.object = object;
          triangle.source = static_cast<std::uint32_t>(scene_.triangles.size()) - first_of_object();
          scene_.triangles.push_back(triangle);
        }
      }
  }
  std::uint32_t first_of_object() const {
    return scene_.objects.empty()
               ? 0
               : scene_.objects.back().first_triangle + scene_.objects.back().triangle_count;
  }

  scene::Scene scene_;
};

inline hierarchy::Hierarchy hierarchy_of(const scene::Scene& scene) {
  std::vector<Aabb> boxes(scene.triangles.size());
  for (std::uint32_t t = 0; t < boxes.size(); ++t)
    for (const Vec3f& p : scene.corners(t)) boxes[t].add(p);
  return hierarchy::build(boxes);
}

/// n x n boxes of 1 m, 2 m apart, on a floor.
inline scene::Scene grid_scene(int n, int materials = 1, int cells = 1) {
  SceneBuilder builder;
  std::vector<std::uint32_t> ids{0};
  for (int m = 1; m < materials; ++m) ids.push_back(builder.add_material());
  const float size = 3.0f * static_cast<float>(n);
  builder.add_box({0, -0.1f, 0}, {size, 0, size}, 0, 0, 4);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const float x = 3.0f * static_cast<float>(i), z = 3.0f * static_cast<float>(j);
      builder.add_box({x, 0, z}, {x + 1, 1, z + 1},
                      ids[static_cast<std::size_t>((i + j) % materials)], 0, cells);
    }
  return builder.take();
}

}  // namespace lightbatch::batches::testing
