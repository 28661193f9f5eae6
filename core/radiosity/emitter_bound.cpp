#include "core/radiosity/emitter_bound.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/hierarchy/descend.h"

namespace lightbatch::radiosity {
namespace {

using hierarchy::Hierarchy;

/// Emitters that are weighed one by one.
constexpr std::size_t kFew = 16;

/// Largest cosine at the emitters of a node, in a sphere of the given radius. to: from the receiver
/// to the middle of the sphere, `distance` long.
float largest_facing(const FacingCone& cone, const Vec3f& to, float distance, float radius) {
  if (cone.cos_angle <= -1 || distance <= radius) return 1;
  const auto sine = [](float cosine) { return std::sqrt(std::max(0.0f, 1 - cosine * cosine)); };
  // The cone widened by the angle that the sphere takes.
  const float sin_wide = radius / distance, cos_wide = sine(sin_wide);
  const float sin_cone = sine(cone.cos_angle);
  const float cos_angle = cone.cos_angle * cos_wide - sin_cone * sin_wide;
  const float sin_angle = sin_cone * cos_wide + cone.cos_angle * sin_wide;
  const float cosine = -dot(cone.axis, to) / distance;
  const bool half_a_turn = sin_angle <= 0;
  if (half_a_turn || cosine >= cos_angle) return 1;
  // Rounding of cosines near 1 in single precision.
  constexpr float kSlack = 5e-4f;
  return std::min(1.0f, cosine * cos_angle + sine(cosine) * sin_angle + kSlack);
}

/// What one emitter may bring: a triangle as from the distance whose inverse square is the mean
/// between its box's nearest and farthest point (1 / (a b), the mean of x^-2 over [a, b]), but no
/// more than where it fills the hemisphere.
float importance_of(const LightSources& sources, Hierarchy::NodeId leaf, const Receiver& at) {
  const Emitter& e = sources.emitters()[sources.emitter_tree().primitives(leaf)[0]];
  if (e.is_point()) return bound_of(sources, leaf, at).importance;
  if (is_own(e, at)) return 0;
  const float height = highest_of(e, at);
  if (height <= 0 && !at.is_in_space()) return 0;
  const float before = -dot(e.a - at.frame.origin, cross(e.b - e.a, e.c - e.a)) / (2 * e.area);
  if (before <= 0 && !e.double_sided) return 0;
  const Aabb box = sources.emitter_tree().box(leaf);
  const float nearest = box.distance_to(at.frame.position);
  const float farthest = box.farthest_from(at.frame.position);
  const auto cosine = [nearest](float h) { return h < nearest ? h / nearest : 1.0f; };
  const float arrives = at.is_in_space() ? 1.0f : cosine(height);
  return e.power * arrives * cosine(std::fabs(before)) /
         (kPi * std::max(nearest * farthest, e.area / kPi) + 1e-30f);
}

/// The emitters of a node, of kFew at most, and what they may bring.
struct Few {
  std::array<double, kFew> up_to{};
  std::array<std::uint32_t, kFew> emitter{};
  std::size_t count = 0;
  double sum = 0;
  Hierarchy::NodeId weighed = scene::kNone;  // the node that they are of

  void weigh(const LightSources& sources, Hierarchy::NodeId node, const Receiver& at) {
    if (node == weighed) return;
    weighed = node;
    const Hierarchy& tree = sources.emitter_tree();
    count = 0;
    sum = 0;
    const Hierarchy::NodeId end = node + 2 * tree.count(node) - 1;
    for (Hierarchy::NodeId i = node; i < end; ++i) {
      if (!tree.is_leaf(i)) continue;
      sum += static_cast<double>(importance_of(sources, i, at));
      emitter[count] = tree.primitive(tree.first(i));
      up_to[count++] = sum;
    }
  }
  ChosenEmitter pick(double random) const {
    if (!(sum > 0)) return {};
    std::size_t k = 0;
    while (k + 1 < count && up_to[k] <= random * sum) ++k;
    return {emitter[k], (up_to[k] - (k > 0 ? up_to[k - 1] : 0)) / sum};
  }
};

}  // namespace

EmitterBound bound_of(const LightSources& sources, Hierarchy::NodeId node, const Receiver& at) {
  const Aabb& box = sources.emitter_tree().box(node);
  const Vec3f to = box.centre() - at.frame.position;
  const float radius = 0.5f * box.diagonal();
  const Vec3f half = box.extent() * 0.5f;
  const Vec3f& n = at.frame.normal;
  const float reach = std::fabs(n.x) * half.x + std::fabs(n.y) * half.y + std::fabs(n.z) * half.z;
  const float height = dot(to, n) + reach;
  if (height <= 0 && !at.is_in_space()) return {};
  const float squared = dot(to, to);
  const float distance = std::sqrt(squared);
  const float cosine =
      at.is_in_space() ? 1.0f
                       : std::min(1.0f, (height + 1e-20f) / std::max(distance, radius + 1e-20f));
  const float facing = largest_facing(sources.facing(node), to, distance, radius);
  if (facing <= 0) return {};
  const float importance =
      sources.power(node) * cosine * facing / (kPi * std::max(squared, radius * radius) + 1e-30f);
  // A receiver inside the box, or close to it, may have one of the emitters right in front of it.
  const float nearest = box.distance_to(at.frame.position);
  const float closest_cosine =
      at.is_in_space() ? 1.0f : std::min(1.0f, height / (nearest + 1e-20f));
  const float most =
      sources.power(node) * closest_cosine * facing / (kPi * nearest * nearest + 1e-30f);
  return {importance, most * std::min(1.0f, 2.0f * radius / (distance + 1e-20f))};
}

ChosenEmitter choose_emitter(const LightSources& sources, const Receiver& at, double random) {
  const Hierarchy& tree = sources.emitter_tree();
  Few few;
  const auto walk = hierarchy::descend(
      tree, 0, random,
      [&](Hierarchy::NodeId id) {
        if (tree.count(id) > kFew) return static_cast<double>(bound_of(sources, id, at).importance);
        few.weigh(sources, id, at);
        return few.sum;
      },
      kFew);
  if (!(walk.probability > 0)) return {};
  few.weigh(sources, walk.node, at);
  const auto [emitter, share] = few.pick(walk.random);
  return {emitter, walk.probability * share};
}

}  // namespace lightbatch::radiosity
