#include "core/radiosity/direct_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "core/hierarchy/descend.h"
#include "core/math/sampling.h"
#include "core/math/sobol.h"
#include "core/radiosity/emitter_bound.h"
#include "core/radiosity/polygon_form_factor.h"
#include "core/radiosity/spherical_triangle.h"

namespace lightbatch::radiosity {
namespace {

using hierarchy::Hierarchy;

/// Of asking a weak light at all. A walk from the root knows little of what is close to one lamp of
/// many, so that it must not be small.
constexpr double kLeastChance = 0.25;

/// A random number moved on in [0, 1), round its end.
float turned(float random, float turn) {
  const float sum = random + turn;
  return std::min(sum < 1 ? sum : sum - 1, 0x1.fffffep-1f);
}

/// A point of an emitter that the receiver's side faces.
struct EmitterSample {
  Vec3f point;
  Vec3d direction;  // unit, from the receiver
  Rgbd light;       // luminance over the density per solid angle, lux; black: nothing
};

/// Squared length of an edge over squared distance, from which on a triangle is large.
constexpr float kLargeTriangle = 0.1f;

EmitterSample sample_point(const PunctualLight& light, const Receiver& at) {
  EmitterSample sample;
  const Vec3f to = light.position - at.frame.position;
  if (!(dot(to, to) > 0)) return sample;
  const Vec3f direction = normalized(to);
  if (!at.is_in_space() && !(dot(direction, at.frame.normal) > 0)) return sample;
  sample.point = light.position;
  sample.direction = to_double(direction);
  sample.light = to_double(light.irradiance(at.frame.position, direction));
  return sample;
}

EmitterSample sample_triangle(const Emitter& e, const Receiver& at, Vec2f random) {
  const Vec3f ab = e.b - e.a, ac = e.c - e.a;
  const Vec3d normal = cross(to_double(ab), to_double(ac));
  const Vec3d from = to_double(at.frame.origin);
  EmitterSample sample;
  Vec2f place;        // barycentric
  double weight = 0;  // 1 over the density per solid angle, sr
  const Vec3f away = e.a - at.frame.origin;
  const float largest = std::max({dot(ab, ab), dot(ac, ac), dot(ac - ab, ac - ab)});
  if (largest > kLargeTriangle * dot(away, away)) {
    const SphericalTriangle seen(from, {e.a, e.b, e.c});
    if (!(seen.solid_angle() > 0)) return sample;
    sample.direction = seen.direction(static_cast<double>(random.x), static_cast<double>(random.y));
    const Vec3d& direction = sample.direction;
    const double facing = dot(direction, normal);
    if (!(e.double_sided ? facing != 0 : facing < 0)) return sample;
    const Vec3d point = direction * (dot(to_double(e.a) - from, normal) / facing);
    // Barycentric in the plane of the triangle.
    const Vec3d local = from + point - to_double(e.a);
    const double scale = 1 / dot(normal, normal);
    const double u = dot(cross(local, to_double(ac)), normal) * scale;
    const double v = dot(cross(to_double(ab), local), normal) * scale;
    if (!std::isfinite(u) || !std::isfinite(v)) return sample;
    place = {static_cast<float>(std::clamp(u, 0.0, 1.0)),
             static_cast<float>(std::clamp(v, 0.0, 1.0))};
    weight = seen.solid_angle();
  } else {
    place = uniform_triangle(random);
    const Vec3d to = to_double(e.a + ab * place.x + ac * place.y) - from;
    const double squared = dot(to, to);
    double facing = -dot(to, normal);
    if (e.double_sided) facing = std::fabs(facing);
    if (!(squared > 0) || !(facing > 0)) return sample;
    const double distance = std::sqrt(squared);
    sample.direction = to / distance;
    weight = 0.5 * facing / (squared * distance);
  }
  if (!at.is_in_space() && !(dot(sample.direction, to_double(at.frame.normal)) > 0)) return {};
  sample.light = to_double(e.luminance) * weight;
  sample.point = e.a + ab * place.x + ac * place.y;
  return sample;
}

EmitterSample sample_emitter(const LightSources& sources, const Emitter& e, const Receiver& at,
                             Vec2f random) {
  return e.is_point() ? sample_point(sources.point(e), at) : sample_triangle(e, at, random);
}

}  // namespace

DirectLight::DirectLight(const optics::Optics& optics, const rays::Caster& caster,
                         const LightSources& sources, bool shadows)
    : optics_(&optics),
      caster_(&caster),
      sources_(&sources),
      lift_(optics::lift_of(optics.scene())),
      filtered_(optics.filtered_count() > 0),
      shadows_(shadows) {}

rays::Ray DirectLight::shadow_ray(const Receiver& at, const Vec3f& point) const {
  const Vec3f to = point - at.frame.origin;
  return {at.frame.origin, to, 0.0f, optics::shadow_end(to, point, lift_)};
}

Rgb DirectLight::through(const rays::Ray& ray, std::uint32_t a, std::uint32_t b,
                         RayCounts& counts) const {
  if (!filtered_) return caster_->occluded(ray, a, b) ? Rgb{} : Rgb{1, 1, 1};
  optics::ShadowFilter filter(*optics_);
  const bool blocked = caster_->occluded(ray, a, b, &filter);
  counts.alpha_lookups += filter.asked();
  return blocked ? Rgb{} : filter.transmittance();
}

Rgb DirectLight::open_irradiance(const Emitter& e, const Receiver& at, RayCounts& counts) const {
  if (e.is_point()) return sources_->point(e).irradiance(at.frame.position, at.frame.normal);
  if (!(highest_of(e, at) > 0)) return {};
  const Vec3d point = to_double(at.frame.position);
  const Vec3d normal = to_double(at.frame.normal);
  ++counts.polygon_factors;
  double factor = point_to_triangle(point, normal, {e.a, e.b, e.c});
  if (factor <= 0 && e.double_sided) {
    factor = point_to_triangle(point, normal, {e.a, e.c, e.b});
  }
  return e.luminance * static_cast<float>(kPiDouble * factor);
}

EmitterTerms::Term DirectLight::emitter_term(const Receiver& at, std::uint32_t emitter,
                                             RayCounts& counts) const {
  const Emitter& e = sources_->emitters()[emitter];
  EmitterTerms::Term term{emitter, 2 * e.lamp, {}, 0, 1, false};
  if (is_own(e, at)) return term;
  term.irradiance = open_irradiance(e, at, counts);
  term.weight = term.irradiance.sum();
  return term;
}

float DirectLight::most_nearby(std::uint32_t emitter, const Receiver& at, float edge) const {
  const Emitter& e = sources_->emitters()[emitter];
  if (is_own(e, at)) return 0;
  if (e.box().distance_to(at.frame.position) > edge * std::numbers::sqrt2_v<float> / 2) return 0;
  if (!(highest_of(e, at) > 0)) return 0;
  const float all = e.power / (e.double_sided ? 2.0f : 1.0f) / (edge * edge);
  return e.is_point() ? all : std::min(all, kPi * e.luminance.sum());
}

void DirectLight::emitter_terms(const Receiver& at, const CutChoice& choice, EmitterTerms& terms,
                                RayCounts& counts, float negligible, float reach) const {
  terms.count = 0;
  terms.close_count = 0;
  terms.total = {};
  terms.weight = 0;
  const auto& emitters = sources_->emitters();
  const auto add = [&](const EmitterTerms::Term& term) {
    if (term.irradiance.is_black()) return;
    terms.term[terms.count++] = term;
    terms.total += term.irradiance;
    terms.weight += term.weight;
  };
  const auto add_one = [&](std::uint32_t index) {
    EmitterTerms::Term term = emitter_term(at, index, counts);
    term.close = reach > 0 && emitters[index].box().distance_to(at.frame.position) < reach;
    if (term.close) terms.close[terms.close_count++] = index;
    add(term);
  };
  if (emitters.size() <= kFewEmitters) {
    for (std::uint32_t i = 0; i < emitters.size(); ++i) add_one(i);
    return;
  }

  // The cut: open the node of largest uncertainty until the table is full or nothing is doubtful.
  struct Node {
    Hierarchy::NodeId id;
    EmitterBound bound;
    bool operator<(const Node& o) const { return bound.uncertainty < o.bound.uncertainty; }
  };
  const Hierarchy& tree = sources_->emitter_tree();
  std::array<Node, EmitterTerms::kCapacity> cut;  // a heap
  std::size_t size = 0;
  float sum = 0;
  const auto heap_end = [&] { return cut.begin() + static_cast<std::ptrdiff_t>(size); };
  const auto push = [&](Hierarchy::NodeId id) {
    EmitterBound bound = bound_of(*sources_, id, at);
    if (bound.importance <= 0) return;
    if (tree.is_leaf(id)) {
      bound.uncertainty = 0;
    } else if (reach > 0 && tree.box(id).distance_to(at.frame.position) < reach) {
      // All of its light may fall on so small a place.
      bound.uncertainty = std::max(bound.uncertainty, sources_->power(id) / (kPi * reach * reach));
    }
    cut[size++] = {id, bound};
    std::push_heap(cut.begin(), heap_end());
    sum += bound.importance;
  };
  push(0);
  while (size > 0 && size < EmitterTerms::kCapacity &&
         cut[0].bound.uncertainty > std::max(choice.tolerance * sum, negligible)) {
    const Node widest = cut[0];
    std::pop_heap(cut.begin(), heap_end());
    --size;
    sum -= widest.bound.importance;
    push(tree.left(widest.id));
    push(tree.right(widest.id));
  }
  Random random(choice.seed);
  for (std::size_t i = 0; i < size; ++i) {
    const std::uint32_t first = tree.primitive(tree.first(cut[i].id));
    if (tree.is_leaf(cut[i].id)) {
      add_one(first);
    } else {
      const std::uint32_t last = tree.primitives(cut[i].id).back();
      const bool one_lamp = emitters[first].lamp == emitters[last].lamp;
      // What is close has been opened: bounds tell enough of the rest.
      const auto walk = hierarchy::descend(
          tree, cut[i].id, turned(random.next_float(), choice.turn),
          [&](Hierarchy::NodeId id) { return bound_of(*sources_, id, at).importance; });
      if (walk.probability > 0) {
        EmitterTerms::Term term = emitter_term(at, tree.primitive(tree.first(walk.node)), counts);
        term.source = one_lamp ? 2 * emitters[first].lamp : 2 * cut[i].id + 1;
        term.scale_by(1 / walk.probability);
        add(term);
      }
    }
  }
}

VisibilitySum DirectLight::emitter_visibility(const Receiver& at, const EmitterTerms& terms,
                                              int rays, std::uint32_t first, std::uint32_t seed,
                                              RayCounts& counts, GroupVisibility* by_group) const {
  VisibilitySum sum;
  if (!shadows_) {
    sum.all = sum.visible = {1, 1, 1};
    return sum;
  }
  if (terms.count == 0 || !(terms.weight > 0)) return sum;
  const OwenSobol8 sequence(seed);
  for (int k = 0; k < rays; ++k) {
    const auto index = first + static_cast<std::uint32_t>(k);
    float choice = sequence.coordinate(index, 2) * terms.weight;
    std::size_t i = 0;
    while (i + 1 < terms.count && choice >= terms.term[i].weight) choice -= terms.term[i++].weight;
    emitter_ray(at, terms.term[i], static_cast<double>(terms.term[i].weight / terms.weight),
                sequence.pair(index, 0), counts, sum, by_group);
  }
  return sum;
}

void DirectLight::emitter_ray(const Receiver& at, const EmitterTerms::Term& term,
                              double probability, Vec2f random, RayCounts& counts,
                              VisibilitySum& sum, GroupVisibility* by_group) const {
  const Emitter& e = sources_->emitters()[term.emitter];
  const EmitterSample sample = sample_emitter(*sources_, e, at, random);
  if (sample.light.is_black()) return;
  const Rgbd all = sample.light * (dot(sample.direction, to_double(at.frame.normal)) *
                                   static_cast<double>(term.scale) / probability);
  ++sum.rays;
  const Rgbd visible = shadows_ ? all * to_double(emitter_share(at, e, sample.point, counts)) : all;
  sum.all += all;
  sum.visible += visible;
  if (by_group == nullptr) return;
  by_group->all[e.group] += all;
  by_group->visible[e.group] += visible;
}

void DirectLight::split_emitters(const EmitterTerms& terms, const Rgb& share,
                                 const GroupVisibility& seen, float scale,
                                 std::span<Rgb> groups) const {
  std::array<Rgb, kMostGroups> part{};
  Rgb sum;
  for (std::size_t i = 0; i < terms.count; ++i) {
    part[sources_->emitters()[terms.term[i].emitter].group] += terms.term[i].irradiance;
  }
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const VisibilitySum own{seen.visible[g], seen.all[g], 1};
    part[g] = part[g] * (seen.all[g].is_black() ? share : own.share());
    sum += part[g];
  }
  const Rgb arrives = terms.total * share;
  const auto ratio = [](float a, float b) { return b > 0 ? a / b : 0.0f; };
  const Rgb even{ratio(arrives.r, sum.r), ratio(arrives.g, sum.g), ratio(arrives.b, sum.b)};
  for (std::size_t g = 0; g < groups.size(); ++g) groups[g] += part[g] * even * scale;
}

Incident DirectLight::sampled_emitter(const Receiver& at, float worth, double pick, Vec2f random,
                                      RayCounts& counts) const {
  if (sources_->emitters().empty()) return {};
  const auto whole = [&] { return static_cast<double>(bound_of(*sources_, 0, at).importance); };
  const double asked =
      worth > 0 ? std::clamp(whole() / static_cast<double>(worth), kLeastChance, 1.0) : 1;
  if (!(pick < asked)) return {};
  const ChosenEmitter chosen = choose_emitter(*sources_, at, pick / asked);
  if (!(chosen.probability > 0)) return {};
  const Emitter& e = sources_->emitters()[chosen.emitter];
  const EmitterSample sample = sample_emitter(*sources_, e, at, random);
  Incident incident{to_float(sample.direction),
                    to_float(sample.light / (asked * chosen.probability)), e.group};
  if (!shadows_ || incident.light.is_black()) return incident;
  incident.light *= emitter_share(at, e, sample.point, counts);
  return incident;
}

Rgb DirectLight::emitter_share(const Receiver& at, const Emitter& e, const Vec3f& point,
                               RayCounts& counts) const {
  ++(e.is_point() ? counts.punctual_shadow : counts.emitter_shadow);
  return through(shadow_ray(at, point), at.triangle, e.triangle, counts);
}

Incident DirectLight::punctual(const Receiver& at, const PunctualLight& light, Vec2f random,
                               RayCounts& counts) const {
  const Vec3f to = light.towards(at.frame.position);
  if (dot(to, to) == 0) return {};
  Incident incident{normalized(to), {}};
  if (!at.is_in_space() && !(dot(incident.direction, at.frame.normal) > 0)) return {};
  incident.light = light.irradiance(at.frame.position, incident.direction);
  if (incident.light.is_black()) return {};
  incident.light *= punctual_visibility(at, light, random, counts);
  return incident;
}

Rgb DirectLight::visibility_towards(const Receiver& at, const PunctualLight& light,
                                    const Vec3f& towards, RayCounts& counts) const {
  // What hides the sky is no shadow of a light.
  if (!shadows_ && !light.is_of_sky()) return {1, 1, 1};
  return through(punctual_ray(at, light, towards, counts), at.triangle, rays::kNoTriangle, counts);
}

rays::Ray DirectLight::punctual_ray(const Receiver& at, const PunctualLight& light,
                                    const Vec3f& towards, RayCounts& counts) const {
  ++(light.is_of_sky() ? counts.sun_shadow : counts.punctual_shadow);
  rays::Ray ray{at.frame.origin, towards};
  if (!light.is_directional()) {
    ray.t_max = optics::shadow_end(ray.direction, at.frame.origin + ray.direction, lift_);
  }
  return ray;
}

std::uint32_t DirectLight::blocker(const Receiver& at, const PunctualLight& light,
                                   RayCounts& counts) const {
  if (!shadows_ && !light.is_of_sky()) return rays::kNoTriangle;
  const rays::Hit hit = caster_->closest(
      punctual_ray(at, light, light.towards(at.frame.origin), counts), at.triangle);
  if (!hit.found()) return rays::kNoTriangle;
  const auto& surfaces = optics_->surfaces();
  const bool opaque = surfaces.empty() || surfaces[hit.triangle] == rays::Surface::kOpaque;
  return opaque ? hit.triangle : rays::kNoTriangle;
}

Rgb DirectLight::point_visibility(const Receiver& at, const Vec3f& point, std::uint32_t triangle,
                                  RayCounts& counts) const {
  ++counts.hemisphere;
  return through(shadow_ray(at, point), at.triangle, triangle, counts);
}

}  // namespace lightbatch::radiosity
