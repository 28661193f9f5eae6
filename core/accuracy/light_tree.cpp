// Many lights, one sample: stochastic descent of a hierarchy over the lights (Estevez and Kulla,
// Importance Sampling of Many Lights, 2018). Left out: cones of emission; leaves are judged exactly
// instead. Whatever can light a point has a positive probability.
#include "core/accuracy/light_tree.h"

#include <algorithm>
#include <cmath>

#include "core/math/sampling.h"
#include "core/math/sobol.h"

namespace lightbatch::accuracy {
namespace {

/// Mean emission of a triangle over 64 points, and a hundredth of its factor, so that a small
/// bright spot of a texture is never taken for black.
float mean_emission(const scene::Scene& scene, const optics::Optics& optics,
                    std::uint32_t triangle) {
  if (!optics.textured_emission(triangle))
    return optics.emission(triangle, 1 / 3.0f, 1 / 3.0f).sum();
  const OwenSobol2 points(triangle);
  Rgb sum;
  for (std::uint32_t i = 0; i < 64; ++i) {
    const Vec2f p = uniform_triangle(points.point(i));
    sum += optics.emission(triangle, p.x, p.y) / 64.0f;
  }
  return sum.sum() + 0.01f * scene.material_of(triangle).emission.sum();
}

}  // namespace

LightTree::LightTree(const scene::Scene& scene, const optics::Optics& optics, const Kinds& kinds) {
  std::vector<Aabb> boxes;
  for (const scene::Light& source : scene.lights) {
    if (source.intensity.is_black()) continue;
    if (source.kind == scene::LightKind::kDirectional) {
      if (!kinds.suns) continue;
      suns_.push_back({to_float(normalized(-source.direction)), source.intensity});
      continue;
    }
    if (source.kind == scene::LightKind::kSpot ? !kinds.spots : !kinds.points) continue;
    Light light;
    light.position = to_float(source.position);
    light.direction = to_float(normalized(source.direction));
    light.intensity = source.intensity;
    light.strength = source.intensity.sum();
    light.range = static_cast<float>(source.range);
    light.spot = source.kind == scene::LightKind::kSpot;
    light.dip_inner = static_cast<float>(1 - source.cos_inner);
    light.dip_outer = static_cast<float>(1 - source.cos_outer);
    lights_.push_back(light);
    Aabb box;
    box.add(light.position);
    boxes.push_back(box);
  }
  for (std::uint32_t t = 0; kinds.emitters && t < scene.triangles.size(); ++t) {
    if (!optics.emits(t)) continue;
    const auto c = scene.corners(t);
    const Vec3d doubled = cross(to_double(c[1] - c[0]), to_double(c[2] - c[0]));
    const auto area = static_cast<float>(length(doubled) / 2);
    Light light;
    light.triangle = t;
    light.position = (c[0] + c[1] + c[2]) / 3.0f;
    light.direction = to_float(normalized(doubled));
    light.strength = mean_emission(scene, optics, t) * area;
    light.both_sides = optics.double_sided(t);
    if (!(light.strength > 0)) continue;
    if (light_of_triangle_.empty()) light_of_triangle_.resize(scene.triangles.size(), kNoLight);
    light_of_triangle_[t] = static_cast<std::uint32_t>(lights_.size());
    lights_.push_back(light);
    Aabb box;
    for (const Vec3f& p : c) box.add(p);
    boxes.push_back(box);
  }
  if (lights_.empty()) return;
  tree_ = hierarchy::build(boxes);
  strength_.resize(tree_.node_count());
  for (Node node = tree_.node_count(); node-- > 0;) {
    strength_[node] = tree_.is_leaf(node)
                          ? lights_[tree_.primitive(tree_.first(node))].strength
                          : strength_[tree_.left(node)] + strength_[tree_.right(node)];
  }
  for (std::uint32_t leaf = 0; leaf < tree_.primitive_count(); ++leaf) {
    lights_[tree_.primitive(leaf)].leaf = leaf;
  }
}

Rgb LightTree::punctual_irradiance(std::uint32_t index, const Vec3f& at,
                                   const Vec3f& normal) const {
  const Light& light = lights_[index];
  const Vec3d to_light = to_double(light.position) - to_double(at);
  const double d2 = dot(to_light, to_light);
  if (!(d2 > 0)) return {};
  const double d = std::sqrt(d2);
  const double cosine = dot(to_light, to_double(normal)) / d;
  if (!(cosine > 0)) return {};
  double factor = cosine / d2;
  if (light.range > 0) {
    const double ratio = d / static_cast<double>(light.range);
    factor *= std::clamp(1 - ratio * ratio * ratio * ratio, 0.0, 1.0);
  }
  if (light.spot) {
    const Vec3d axis = to_double(light.direction);
    const double sine = length(cross(to_light, axis)), along = -dot(to_light, axis);
    const double half = std::sin(std::atan2(sine, along) / 2);
    const double left = static_cast<double>(light.dip_outer) - 2 * half * half;
    const double width = static_cast<double>(light.dip_outer - light.dip_inner);
    const double ramp = left <= 0 ? 0 : left >= width ? 1 : left / width;
    factor *= ramp * ramp;
  }
  return to_float(to_double(light.intensity) * factor);
}

double LightTree::importance(Node node, const Vec3f& at, const Vec3f& normal) const {
  const Aabb& box = tree_.box(node);
  if (tree_.is_leaf(node)) {
    const std::uint32_t index = tree_.primitive(tree_.first(node));
    const Light& light = lights_[index];
    if (light.triangle == kNoTriangle) {
      return static_cast<double>(punctual_irradiance(index, at, normal).sum());
    }
    if (!light.both_sides && dot(light.direction, at - light.position) <= 0) return 0;
  }
  const Vec3f half = box.extent() * 0.5f;
  const Vec3f to_centre = box.centre() - at;
  const float reach =
      std::fabs(normal.x) * half.x + std::fabs(normal.y) * half.y + std::fabs(normal.z) * half.z;
  const float height = dot(to_centre, normal) + reach;
  if (!(height > 0)) return 0;
  const float near2 = std::max(dot(to_centre, to_centre), dot(half, half));
  const float cosine = std::min(1.0f, height / std::sqrt(near2));
  return static_cast<double>(strength_[node]) * static_cast<double>(cosine / near2);
}

LightTree::Pick LightTree::pick(const Vec3f& at, const Vec3f& normal, double random) const {
  Node node = 0;
  double chance = 1;
  if (tree_.is_leaf(node) && !(importance(node, at, normal) > 0)) return {};
  while (!tree_.is_leaf(node)) {
    const Node left = tree_.left(node), right = tree_.right(node);
    const double a = importance(left, at, normal), b = importance(right, at, normal);
    if (!(a + b > 0) || !std::isfinite(a + b)) return {};
    const double share = a / (a + b);
    if (random < share) {
      node = left;
      chance *= share;
      random /= share;
    } else {
      node = right;
      chance *= 1 - share;
      random = (random - share) / (1 - share);
    }
    random = std::min(random, 0x1.fffffffffffffp-1);
  }
  return {tree_.primitive(tree_.first(node)), chance};
}

double LightTree::probability(std::uint32_t light, const Vec3f& at, const Vec3f& normal) const {
  const std::uint32_t leaf = lights_[light].leaf;
  Node node = 0;
  double chance = 1;
  if (tree_.is_leaf(node) && !(importance(node, at, normal) > 0)) return 0;
  while (!tree_.is_leaf(node)) {
    const Node left = tree_.left(node), right = tree_.right(node);
    const double a = importance(left, at, normal), b = importance(right, at, normal);
    if (!(a + b > 0) || !std::isfinite(a + b)) return 0;
    const bool go_left = leaf < tree_.first(right);
    chance *= go_left ? a / (a + b) : 1 - a / (a + b);
    node = go_left ? left : right;
  }
  return chance;
}

}  // namespace lightbatch::accuracy
