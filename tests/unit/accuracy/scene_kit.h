#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/hierarchy/hierarchy.h"
#include "core/optics/environment.h"
#include "core/optics/optics.h"
#include "core/rays/caster.h"
#include "core/scene/scene.h"

namespace lightbatch::accuracy {

/// A scene put together in code.
class SceneKit {
 public:
  std::uint32_t material(const Rgb& reflectance, const Rgb& emission = {},
                         bool double_sided = false) {
    scene::Material m;
    m.base_color = reflectance;
    m.metallic = 0;
    m.emission = emission;
    m.double_sided = double_sided;
    return material(m);
  }
  std::uint32_t material(const scene::Material& m) {
    scene_.materials.push_back(m);
    return static_cast<std::uint32_t>(scene_.materials.size() - 1);
  }
  /// Two triangles, front counter-clockwise; returns the first. uv0 spans the unit square.
  std::uint32_t quad(const std::array<Vec3f, 4>& p, std::uint32_t material) {
    const auto first = static_cast<std::uint32_t>(scene_.triangles.size());
    const auto base = static_cast<std::uint32_t>(scene_.positions.size());
    for (const Vec3f& corner : p) scene_.positions.push_back(corner);
    for (const Vec2f uv : {Vec2f{0, 0}, Vec2f{1, 0}, Vec2f{1, 1}, Vec2f{0, 1}}) {
      scene_.uv0.push_back(uv);
    }
    scene::Object object;
    object.material = material;
    object.first_triangle = first;
    object.triangle_count = 2;
    const auto index = static_cast<std::uint32_t>(scene_.objects.size());
    scene_.objects.push_back(object);
    scene_.triangles.push_back({{base, base + 1, base + 2}, index, 0});
    scene_.triangles.push_back({{base, base + 2, base + 3}, index, 1});
    return first;
  }
  /// Six quads, fronts inwards (or outwards).
  std::uint32_t box(const Vec3f& a, const Vec3f& b, std::uint32_t material, bool inwards = true) {
    const std::array<Vec3f, 8> v = {Vec3f{a.x, a.y, a.z}, {b.x, a.y, a.z}, {b.x, b.y, a.z},
                                    {a.x, b.y, a.z},      {a.x, a.y, b.z}, {b.x, a.y, b.z},
                                    {b.x, b.y, b.z},      {a.x, b.y, b.z}};
    constexpr std::array<std::array<std::size_t, 4>, 6> kFaces = {
        {{0, 1, 2, 3}, {7, 6, 5, 4}, {4, 5, 1, 0}, {3, 2, 6, 7}, {0, 3, 7, 4}, {5, 6, 2, 1}}};
    const auto first = static_cast<std::uint32_t>(scene_.triangles.size());
    for (const auto& f : kFaces) {
      if (inwards) {
        quad({v[f[0]], v[f[1]], v[f[2]], v[f[3]]}, material);
      } else {
        quad({v[f[3]], v[f[2]], v[f[1]], v[f[0]]}, material);
      }
    }
    return first;
  }
  scene::Scene& scene() { return scene_; }
  const scene::Scene& scene() const { return scene_; }

  /// Call once everything is in.
  void finish() {
    std::vector<Aabb> boxes;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (const Vec3f& p : scene_.positions) scene_.box.add(p);
    for (const scene::Triangle& t : scene_.triangles) {
      Aabb box;
      for (const std::uint32_t v : t.vertex) box.add(scene_.positions[v]);
      boxes.push_back(box);
      triangles.push_back(t.vertex);
    }
    tree_ = hierarchy::build(boxes);
    optics_ = std::make_unique<optics::Optics>(scene_);
    caster_ =
        std::make_unique<rays::Caster>(tree_, scene_.positions, triangles, optics_->surfaces());
  }
  const hierarchy::Hierarchy& tree() const { return tree_; }
  const optics::Optics& optics() const { return *optics_; }
  const rays::Caster& caster() const { return *caster_; }

 private:
  scene::Scene scene_;
  hierarchy::Hierarchy tree_;
  std::unique_ptr<optics::Optics> optics_;
  std::unique_ptr<rays::Caster> caster_;
};

}  // namespace lightbatch::accuracy
