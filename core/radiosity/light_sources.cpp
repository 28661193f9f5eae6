#include "core/radiosity/light_sources.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/math/sampling.h"
#include "core/radiosity/emission_parts.h"

namespace lightbatch::radiosity {
namespace {

/// Emitters from which on triangles stay whole.
constexpr std::size_t kMostParts = 200'000;
/// Triangles whose emission is measured at one time.
constexpr std::size_t kEmittersAtOnce = 4096;
/// Emitters are one lamp where their area is this share of the surface of their box: a panel fills
/// a half of it, two panels a panel apart a third.
constexpr double kLampFill = 0.4;

}  // namespace

FacingCone FacingCone::of(const Emitter& e) {
  if (e.is_point() || e.double_sided) return {};
  const Vec3d normal = cross(to_double(e.b - e.a), to_double(e.c - e.a));
  if (!(dot(normal, normal) > 0)) return {};
  return {to_float(normalized(normal)), 1};
}

FacingCone FacingCone::around(const FacingCone& a, const FacingCone& b) {
  const double angle_a = std::acos(std::clamp(static_cast<double>(a.cos_angle), -1.0, 1.0));
  const double angle_b = std::acos(std::clamp(static_cast<double>(b.cos_angle), -1.0, 1.0));
  if (angle_b > angle_a) return around(b, a);
  const Vec3d axis = to_double(a.axis), other = to_double(b.axis);
  const double between = std::acos(std::clamp(dot(axis, other), -1.0, 1.0));
  if (between + angle_b <= angle_a) return a;
  const double angle = (angle_a + between + angle_b) / 2;
  const Vec3d across = other - axis * dot(axis, other);
  if (angle >= kPiDouble || !(dot(across, across) > 0)) return {};
  const double turn = angle - angle_a;
  const Vec3d middle = axis * std::cos(turn) + normalized(across) * std::sin(turn);
  return {to_float(normalized(middle)), static_cast<float>(std::cos(angle))};
}

Rgb PunctualLight::irradiance(const Vec3f& at, const Vec3f& normal) const {
  if (kind == scene::LightKind::kDirectional) {
    return intensity * std::max(0.0f, -dot(normal, direction));
  }
  const Vec3f to = position - at;
  const float squared = dot(to, to);
  const float cosine = dot(normal, to);
  if (!(cosine > 0) || !(squared > 0)) return {};
  return intensity * (cosine / (squared * std::sqrt(squared)) * window(at));
}

float PunctualLight::window(const Vec3f& at) const {
  const Vec3f from = at - position;
  const float squared = dot(from, from);
  float factor = 1;
  if (range > 0) {
    const float ratio = squared / (range * range);
    factor = std::clamp(1.0f - ratio * ratio, 0.0f, 1.0f);
  }
  if (kind != scene::LightKind::kSpot || !(squared > 0)) return factor;
  const float cosine = dot(direction, from) / std::sqrt(squared);
  const Vec3f across = cross(direction, from);
  const float dip = cosine > 0 ? dot(across, across) / squared / (1 + cosine) : 1 - cosine;
  if (dip_inner >= dip_outer) return dip < dip_outer ? factor : 0;
  const float ramp = std::clamp((dip_outer - dip) / (dip_outer - dip_inner), 0.0f, 1.0f);
  return factor * ramp * ramp;
}

LightSources::LightSources(const scene::Scene& scene, const optics::Optics& optics,
                           const Kinds& kinds, std::vector<optics::SkySun> suns)
    : suns_(std::move(suns)) {
  Grouping grouping;
  add_punctual(scene, kinds, grouping);
  add_points(kinds);
  if (kinds.emitters) add_emitters(scene, optics, grouping);
  build_tree();
  find_lamps();
  auto [groups, renumber] = grouping.finish();
  groups_ = std::move(groups);
  for (PunctualLight& light : punctual_) light.group = renumber[light.group];
  for (PunctualLight& light : points_) light.group = renumber[light.group];
  for (Emitter& emitter : emitters_) emitter.group = renumber[emitter.group];
  for (std::uint32_t i = 0; i < suns_.size(); ++i) {
    PunctualLight sun;
    sun.kind = scene::LightKind::kDirectional;
    sun.direction = -suns_[i].towards();
    sun.intensity = suns_[i].illuminance();
    sun.group = static_cast<std::uint32_t>(groups_.size());
    sun.sun = i;
    punctual_.push_back(sun);
  }
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
                         static_cast<float>(light.range), static_cast<float>(1 - light.cos_inner),
                         static_cast<float>(1 - light.cos_outer)});
    // Lumens, the sun's on an area of the scene's size.
    const double spread =
        light.kind == scene::LightKind::kDirectional ? size * size : 4 * kPiDouble;
    punctual_.back().group =
        grouping.add({LightGroup::Kind::kPunctual, light.gltf_index, light.name, light.intensity},
                     spread * static_cast<double>(light.intensity.sum()));
  }
}

void LightSources::add_points(const Kinds& kinds) {
  const auto local = [](const PunctualLight& light) { return !light.is_directional(); };
  const auto count = std::count_if(punctual_.begin(), punctual_.end(), local);
  if (!kinds.points_as_emitters || count <= static_cast<std::ptrdiff_t>(kMostPunctual)) return;
  for (const PunctualLight& light : punctual_) {
    if (!local(light)) continue;
    Emitter e;
    e.a = e.b = e.c = light.position;
    e.luminance = light.intensity;
    e.power = kPi * light.intensity.sum();
    e.group = light.group;
    e.point = static_cast<std::uint32_t>(points_.size());
    points_.push_back(light);
    emitters_.push_back(e);
  }
  std::erase_if(punctual_, local);
}

void LightSources::add_emitters(const scene::Scene& scene, const optics::Optics& optics,
                                Grouping& grouping) {
  std::size_t uneven = 0;
  for (std::uint32_t i = 0; i < scene.triangles.size(); ++i) {
    if (EmissionParts::is_uneven(optics, i)) ++uneven;
  }
  std::vector<std::uint32_t> emitting;
  for (std::uint32_t i = 0; i < scene.triangles.size(); ++i) {
    if (optics.emits(i)) emitting.push_back(i);
  }
  // In blocks, so that memory stays small.
  std::vector<std::optional<EmissionParts>> parts;
  for (std::size_t first = 0; first < emitting.size(); first += kEmittersAtOnce) {
    const std::size_t count = std::min(kEmittersAtOnce, emitting.size() - first);
    parts = std::vector<std::optional<EmissionParts>>(count);
    parallel_for(count, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        parts[k].emplace(optics, emitting[first + k], uneven);
      }
    });
    for (std::size_t k = 0; k < count; ++k) {
      add_emitter(scene, optics, emitting[first + k], *parts[k], grouping);
    }
  }
}

void LightSources::add_emitter(const scene::Scene& scene, const optics::Optics& optics,
                               std::uint32_t triangle, const EmissionParts& parts,
                               Grouping& grouping) {
  const auto corner = scene.corners(triangle);
  const bool cut = optics.textured_emission(triangle) && emitters_.size() < kMostParts;
  parts.for_each(cut, [&](const EmissionParts::Part& part, const Rgb& luminance) {
    if (luminance.is_black()) return;
    const auto place = [&](const Vec2f& p) {
      return corner[0] * (1 - p.x - p.y) + corner[1] * p.x + corner[2] * p.y;
    };
    Emitter e;
    e.triangle = triangle;
    e.a = place(part[0]);
    e.b = place(part[1]);
    e.c = place(part[2]);
    e.luminance = luminance;
    e.area = static_cast<float>(0.5 * length(cross(to_double(e.b - e.a), to_double(e.c - e.a))));
    e.double_sided = optics.double_sided(triangle);
    e.power = kPi * e.area * e.luminance.sum() * (e.double_sided ? 2.0f : 1.0f);
    const scene::Material& material = scene.material_of(triangle);
    e.group = grouping.add(
        {LightGroup::Kind::kEmitter, material.gltf_index, material.name, material.emission},
        static_cast<double>(e.power));
    emitters_.push_back(e);
  });
}

void LightSources::build_tree() {
  if (emitters_.empty()) return;
  std::vector<Aabb> boxes;
  boxes.reserve(emitters_.size());
  for (const Emitter& e : emitters_) boxes.push_back(e.box());
  emitter_tree_ = hierarchy::build(boxes);
  node_power_.resize(emitter_tree_.node_count());
  node_facing_.resize(emitter_tree_.node_count());
  for (auto node = emitter_tree_.node_count(); node-- > 0;) {
    if (emitter_tree_.is_leaf(node)) {
      const Emitter& e = emitters_[emitter_tree_.primitive(emitter_tree_.first(node))];
      node_power_[node] = e.power;
      node_facing_[node] = FacingCone::of(e);
    } else {
      const auto left = emitter_tree_.left(node), right = emitter_tree_.right(node);
      node_power_[node] = node_power_[left] + node_power_[right];
      node_facing_[node] = FacingCone::around(node_facing_[left], node_facing_[right]);
    }
  }
}

void LightSources::find_lamps() {
  if (emitters_.empty()) return;
  using NodeId = hierarchy::Hierarchy::NodeId;
  std::vector<double> area(emitter_tree_.node_count());
  for (auto node = emitter_tree_.node_count(); node-- > 0;) {
    area[node] = emitter_tree_.is_leaf(node)
                     ? static_cast<double>(
                           emitters_[emitter_tree_.primitive(emitter_tree_.first(node))].area)
                     : area[emitter_tree_.left(node)] + area[emitter_tree_.right(node)];
  }
  std::vector<NodeId> stack{0};
  std::uint32_t lamps = 0;
  while (!stack.empty()) {
    const NodeId node = stack.back();
    stack.pop_back();
    const Vec3f extent = emitter_tree_.box(node).extent();
    const double around =
        2.0 * static_cast<double>(extent.x * extent.y + extent.y * extent.z + extent.z * extent.x);
    if (emitter_tree_.is_leaf(node) || area[node] >= kLampFill * around) {
      for (const std::uint32_t e : emitter_tree_.primitives(node)) emitters_[e].lamp = lamps;
      ++lamps;
      continue;
    }
    stack.push_back(emitter_tree_.right(node));
    stack.push_back(emitter_tree_.left(node));
  }
}

}  // namespace lightbatch::radiosity
