#include "core/radiosity/light_sources.h"

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/hierarchy/descend.h"
#include "core/math/sampling.h"

namespace lightbatch::radiosity {
namespace {

/// Mean emitted luminance over a triangle; a texture is sampled on a stratified 8 x 8 pattern.
Rgb mean_emission(const optics::Optics& optics, std::uint32_t triangle) {
  if (!optics.textured_emission(triangle)) return optics.emission(triangle, 1.0f / 3, 1.0f / 3);
  constexpr int kSide = 8;
  Rgbd sum;
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      const Vec2f p = uniform_triangle(
          {(static_cast<float>(i) + 0.5f) / kSide, (static_cast<float>(j) + 0.5f) / kSide});
      sum += to_double(optics.emission(triangle, p.x, p.y));
    }
  }
  return to_float(sum / static_cast<double>(kSide * kSide));
}

}  // namespace

Rgb PunctualLight::irradiance(const Vec3f& at, const Vec3f& normal) const {
  if (kind == scene::LightKind::kDirectional) {
    return intensity * std::max(0.0f, -dot(normal, direction));
  }
  const Vec3f to = position - at;
  const float squared = dot(to, to);
  const float cosine = dot(normal, to);
  if (!(cosine > 0) || !(squared > 0)) return {};
  const float distance = std::sqrt(squared);
  float factor = cosine / (squared * distance);
  if (range > 0) {
    const float ratio = distance / range;
    const float fourth = ratio * ratio * ratio * ratio;
    factor *= std::clamp(1.0f - fourth, 0.0f, 1.0f);
  }
  if (kind == scene::LightKind::kSpot) {
    const float away = -dot(direction, to) / distance;
    const float ramp =
        std::clamp((away - cos_outer) / std::max(1e-6f, cos_inner - cos_outer), 0.0f, 1.0f);
    factor *= ramp * ramp;
  }
  return intensity * factor;
}

LightSources::LightSources(const scene::Scene& scene, const optics::Optics& optics,
                           const Kinds& kinds) {
  Grouping grouping;
  add_punctual(scene, kinds, grouping);
  if (kinds.emitters) add_emitters(scene, optics, grouping);
  auto [groups, renumber] = grouping.finish();
  groups_ = std::move(groups);
  for (PunctualLight& light : punctual_) light.group = renumber[light.group];
  for (Emitter& emitter : emitters_) emitter.group = renumber[emitter.group];
}

void LightSources::add_punctual(const scene::Scene& scene, const Kinds& kinds, Grouping& grouping) {
  const auto size = static_cast<double>(scene.box.diagonal());
  for (const scene::Light& light : scene.lights) {
    const bool wanted = light.kind == scene::LightKind::kPoint  ? kinds.point
                        : light.kind == scene::LightKind::kSpot ? kinds.spot
                                                                : kinds.directional;
    if (!wanted || light.intensity.is_black()) continue;
    punctual_.push_back({light.kind, to_float(light.position),
                         to_float(normalized(light.direction)), light.intensity,
                         static_cast<float>(light.range), static_cast<float>(light.cos_inner),
                         static_cast<float>(light.cos_outer)});
    // Lumens, the sun's on an area of the scene's size.
    const double spread =
        light.kind == scene::LightKind::kDirectional ? size * size : 4 * kPiDouble;
    punctual_.back().group =
        grouping.add({LightGroup::Kind::kPunctual, light.gltf_index, light.name, light.intensity},
                     spread * static_cast<double>(light.intensity.sum()));
  }
}

void LightSources::add_emitters(const scene::Scene& scene, const optics::Optics& optics,
                                Grouping& grouping) {
  std::vector<Aabb> boxes;
  for (std::uint32_t i = 0; i < scene.triangles.size(); ++i) {
    if (!optics.emits(i)) continue;
    const auto corner = scene.corners(i);
    Emitter e;
    e.triangle = i;
    e.a = corner[0];
    e.b = corner[1];
    e.c = corner[2];
    e.luminance = mean_emission(optics, i);
    if (e.luminance.is_black()) continue;
    e.area = static_cast<float>(0.5 * length(cross(to_double(e.b - e.a), to_double(e.c - e.a))));
    e.double_sided = optics.double_sided(i);
    e.textured = optics.textured_emission(i);
    e.power = kPi * e.area * e.luminance.sum() * (e.double_sided ? 2.0f : 1.0f);
    const scene::Material& material = scene.material_of(i);
    e.group = grouping.add(
        {LightGroup::Kind::kEmitter, material.gltf_index, material.name, material.emission},
        static_cast<double>(e.power));
    Aabb box;
    for (const Vec3f& p : corner) box.add(p);
    boxes.push_back(box);
    emitters_.push_back(e);
  }
  if (emitters_.empty()) return;
  emitter_tree_ = hierarchy::build(boxes);
  node_power_.resize(emitter_tree_.node_count());
  for (auto node = emitter_tree_.node_count(); node-- > 0;) {
    node_power_[node] =
        emitter_tree_.is_leaf(node)
            ? emitters_[emitter_tree_.primitive(emitter_tree_.first(node))].power
            : node_power_[emitter_tree_.left(node)] + node_power_[emitter_tree_.right(node)];
  }
}

std::uint32_t LightSources::pick(hierarchy::Hierarchy::NodeId node, float random) const {
  // Every emitter has power, so that every walk ends at a leaf.
  const auto walk =
      hierarchy::descend(emitter_tree_, node, random, [&](auto n) { return power(n); });
  return emitter_tree_.primitive(emitter_tree_.first(walk.leaf));
}

}  // namespace lightbatch::radiosity
