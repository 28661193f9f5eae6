#pragma once

#include "core/scene_in/read_scene.h"
#include "tests/unit/gltf/scene_files.h"

namespace lightbatch::scene_in {

using gltf::Json;
using gltf::SceneBuilder;

/// Reads the builder's scene end to end; fails the test when it is refused.
inline scene::Scene read(const SceneBuilder& builder, const gltf::ReadLimits& limits = {}) {
  const auto document = builder.read(limits);
  EXPECT_TRUE(document.ok()) << document.status().to_string();
  if (!document.ok()) return {};
  auto scene = read_scene(*document, limits);
  EXPECT_TRUE(scene.ok()) << scene.status().to_string();
  return scene.ok() ? std::move(scene).value() : scene::Scene{};
}

/// builder.square() with its lower corners on the first joint of a skin, its upper on the second.
inline void skinned_square(SceneBuilder& builder) {
  builder.square();
  builder.primitive()["attributes"]["JOINTS_0"] = builder.accessor(
      std::vector<std::uint8_t>{0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 4);
  builder.primitive()["attributes"]["WEIGHTS_0"] = builder.accessor(
      std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 4);
}

inline Vec3d world_corner(const scene::Scene& scene, std::uint32_t triangle, std::size_t corner) {
  return scene.origin + to_double(scene.corners(triangle)[corner]);
}

/// Twice the area, towards the front.
inline Vec3d world_normal(const scene::Scene& scene, std::uint32_t triangle) {
  const Vec3d a = world_corner(scene, triangle, 0);
  return cross(world_corner(scene, triangle, 1) - a, world_corner(scene, triangle, 2) - a);
}

inline double total_area(const scene::Scene& scene) {
  double area = 0;
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
    area += 0.5 * length(world_normal(scene, t));
  }
  return area;
}

}  // namespace lightbatch::scene_in
