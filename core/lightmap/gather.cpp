#include "core/lightmap/gather.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/math/sampling.h"
#include "core/math/sobol.h"
#include "core/radiosity/hemisphere_walk.h"
#include "core/radiosity/resolved_light.h"

namespace lightbatch::lightmap {
namespace {

using radiosity::ElementId;
using radiosity::Receiver;

/// Further gathers of a ray before Russian roulette decides on more, and at most. In a crack every
/// hit is near: cut short, the walk would end on an element that lies mostly outside.
constexpr int kSureDepth = 2;
constexpr int kMaxDepth = 256;
/// Extent of a full element over the root of its area: a square's diagonal, and a bit.
constexpr float kElementSize = 1.5f;
/// Differences between neighbours that noise and plain gradients explain.
constexpr float kPlainVariation = 0.3f;
/// A second gather in a row is worth less: what it reads has been reflected once more.
constexpr float kLaterReach = 0.5f;
/// Emitters that bring less than this share of the mean irradiance to a point that is itself one
/// sample of many are asked now and then.
constexpr float kWorthAsking = 0.1f;
/// Share of an open element's hemisphere that is near, as in a corner of a room.
constexpr float kPlainCrowding = 0.25f;
/// How much farther such an element is replaced.
constexpr float kVariationReach = 8.0f;

/// Rays of a texel after which their price is known.
constexpr std::uint32_t kFirstRays = 16;
/// Rays of a texel to virtual lights, at least.
constexpr int kFewestVirtual = 4;
/// Casts that a ray takes in the open, further gathers and shadow rays included.
constexpr double kPlainCasts = 3;

/// Rays of a texel where each takes `casts`: least squares for a number of casts has rays ~
/// casts^-1/2. In a crack of white walls a ray takes a hundred.
std::uint32_t worth_casting(int rays, double casts) {
  const double share = std::sqrt(kPlainCasts / std::max(kPlainCasts, casts));
  return std::min(static_cast<std::uint32_t>(rays),
                  std::max(2 * kFirstRays, static_cast<std::uint32_t>(share * rays)));
}

/// How far an element extends, metres. A cell of a sliver is far longer than the root of its area.
float extent_of(const BakeInput& input, ElementId e) {
  const float full = kElementSize * std::sqrt(input.elements.area(e));
  if (!input.elements.is_cell(e)) return full;
  const radiosity::Elements::Outline outline = input.elements.outline(e);
  const auto at = [&](std::size_t k) {
    const radiosity::ElementPoint& p = outline.corner[k];
    const auto c = input.scene.corners(p.triangle);
    return c[0] * (1 - p.u - p.v) + c[1] * p.u + c[2] * p.v;
  };
  float longest = 0;
  for (std::size_t k = 0; k < outline.count; ++k) {
    for (std::size_t j = 0; j < k; ++j) longest = std::max(longest, length(at(k) - at(j)));
  }
  return std::max(full, longest);
}

/// The first point stands for all.
radiosity::VirtualLights::ReceiverPatch receiver_patch(const TexelPoints& points,
                                                       Receivers& receivers) {
  constexpr Vec2f kMiddle{0.5f, 0.5f};
  const optics::SurfaceFrame first = receivers(points.point[0], kMiddle).frame;
  radiosity::VirtualLights::ReceiverPatch one{first.position, first.normal};
  for (std::uint32_t i = 1; i < points.count; ++i) {
    const optics::SurfaceFrame other = receivers(points.point[i], kMiddle).frame;
    one.extent = std::max(one.extent, length(other.position - first.position));
    one.tilt = std::max(one.tilt, length(other.normal - first.normal));
  }
  return one;
}

}  // namespace

Gather::Gather(const BakeInput& input, const GatherSettings& settings, const Aids* aids)
    : input_(input),
      settings_(settings),
      aids_(aids),
      resolved_(input.direct.sources().punctual().size(), radiosity::kResolvedLights),
      extent_(input.elements.count()),
      near_(input.elements.count()) {
  for (std::size_t k = 0; k < input.solution.resolved.size(); ++k) {
    resolved_[input.solution.resolved[k]] = static_cast<std::uint8_t>(k);
  }
  const radiosity::Elements& elements = input.elements;
  const auto& indirect = input.solution.indirect;
  parallel_for(near_.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto e = static_cast<ElementId>(i);
      extent_[i] = extent_of(input, e);
      // Against the element's own size: most elements of furniture are far smaller than the edge.
      const double size = std::min(elements.edge(), static_cast<double>(extent_[i]));
      // An element that differs much from its neighbours, or has much close above it, varies much
      // inside (it lies partly in a crack or under something): what it holds is right only from
      // afar.
      float variation = 0;
      if (elements.is_cell(e) && !indirect.empty()) {
        std::array<ElementId, 8> around{};
        const std::size_t count = elements.neighbours(e, around.data());
        const float own = indirect[e].sum();
        for (std::size_t k = 0; k < count; ++k) {
          const float other = indirect[around[k]].sum();
          const float larger = std::max(own, other);
          if (larger > 0) variation = std::max(variation, std::fabs(own - other) / larger);
        }
      }
      float excess = std::max(0.0f, variation - kPlainVariation);
      if (!input.solution.crowding.empty()) {
        excess = std::max(excess, input.solution.crowding[e] - kPlainCrowding);
      }
      near_[i] = static_cast<float>(settings.deeper * size) * (1 + kVariationReach * excess);
      // Half in one room, half in another.
      if (input.lookup.is_split(e)) near_[i] = std::numeric_limits<float>::infinity();
    }
  });
}

ElementId Gather::served(const rays::Hit& hit, const Path& path) const {
  if (path.receiver == nullptr) return radiosity::kNoElement;
  // Where virtual lights lie, whatever is read in its place.
  const ElementId e = input_.elements.at(hit.triangle, hit.u, hit.v, hit.back);
  if (e == radiosity::kNoElement) return e;
  const auto at = optics::surface_frame(input_.scene, hit.triangle, hit.u, hit.v, hit.back, 0.0f);
  return aids_->lights.serves(e, *path.receiver, at) ? e : radiosity::kNoElement;
}

Rgb Gather::read(ElementId e, const rays::Hit& hit, ElementId served, const Path& path,
                 BakeCounts& counts) const {
  const radiosity::Solution& solution = input_.solution;
  if (path.grouped()) {
    const auto unresolved = solution.unresolved_by_group.of(e);
    for (std::size_t g = 0; g < unresolved.size(); ++g) path.add(g, unresolved[g]);
  }
  if (!radiosity::has_resolved(solution, e)) return solution.unresolved[e];
  const Rgb reflectance =
      radiosity::reflectance_at(input_.optics, input_.elements, e, hit.triangle, hit.u, hit.v);
  const auto deliver = [&](std::uint32_t group, const Rgb& arrives) {
    if (path.grouped()) path.add(group, reflectance * arrives);
  };
  const bool with_resolved = served == radiosity::kNoElement;
  const Rgb arrives = radiosity::sharp_irradiance(input_.scene, input_.direct, solution, e, hit,
                                                  with_resolved, counts.rays, deliver);
  return solution.unresolved[e] + reflectance * arrives;
}

Rgb Gather::direct(const Receiver& at, ElementId served, Random& random, const Path& path,
                   BakeCounts& counts) const {
  Rgb irradiance{};
  const auto& lights = input_.direct.sources().punctual();
  for (std::size_t l = 0; l < lights.size(); ++l) {
    const Rgb open = lights[l].irradiance(at.frame.position, at.frame.normal);
    if (open.is_black()) continue;
    if (served != radiosity::kNoElement && resolved_[l] < radiosity::kResolvedLights &&
        input_.solution.state(served, resolved_[l]) != radiosity::LightState::kDark) {
      continue;
    }
    const Vec2f on_sun =
        lights[l].is_of_sky() ? Vec2f{random.next_float(), random.next_float()} : Vec2f{};
    const Rgb arrives =
        open * input_.direct.punctual_visibility(at, lights[l], on_sun, counts.rays);
    irradiance += arrives;
    if (path.grouped()) path.add(lights[l].group, arrives);
  }
  const Vec2f on_emitter{random.next_float(), random.next_float()};
  const auto emitted =
      input_.direct.sampled_emitters(at, kWorthAsking * static_cast<float>(input_.mean_irradiance),
                                     random.next_double(), on_emitter, counts.rays);
  irradiance += emitted.irradiance;
  if (path.grouped()) path.add(emitted.group, emitted.irradiance);
  return irradiance;
}

Rgb Gather::stand_for(ElementId e, const Path& path, const Rgb& weight) const {
  const radiosity::Solution& solution = input_.solution;
  if (solution.indirect.empty()) return {};
  const Rgb light = weight * solution.indirect[e];
  if (!path.grouped()) return light;
  const auto groups = solution.unresolved_by_group.of(e);
  Rgb sum{};
  for (const Rgb& part : groups) sum += part;
  const auto share = [](float part, float all) { return all > 0 ? part / all : 0.0f; };
  for (std::size_t g = 0; g < groups.size(); ++g) {
    path.add(g, light * Rgb{share(groups[g].r, sum.r), share(groups[g].g, sum.g),
                            share(groups[g].b, sum.b)});
  }
  return light;
}

Rgb Gather::gather_deeper(ElementId e, const rays::Hit& hit, ElementId served,
                          const Numbers& numbers, int depth, const Path& path,
                          BakeCounts& counts) const {
  ++counts.deeper_gathers;
  Random random(mix_bits(numbers.seed ^ hit.triangle));
  // A walk goes by means: white spots of a texture would make it long.
  Rgb reflectance = depth > 0 ? input_.elements.reflectance(e)
                              : radiosity::reflectance_at(input_.optics, input_.elements, e,
                                                          hit.triangle, hit.u, hit.v);
  bool through = false;
  if (const Rgb tau = input_.elements.transmittance(e); !tau.is_black()) {
    // One side or the other.
    const float back = reflectance.max() / (reflectance.max() + tau.max());
    through = !(random.next_float() < back);
    reflectance = through ? tau * (1 / (1 - back)) : reflectance * (1 / back);
  }
  const Receiver at{optics::surface_frame(input_.scene, hit.triangle, hit.u, hit.v,
                                          hit.back != through, input_.direct.lift()),
                    hit.triangle};
  if (path.links != nullptr && !through && !input_.lookup.is_split(e)) {
    const std::uint32_t texel = aids_->near.at(hit, hit.t, extent_[e] / kElementSize);
    if (texel != scene::kNone) {
      ++counts.near_links;
      const Path own = path.further(reflectance);
      own.links->push_back({texel, own.weight});
      return reflectance * (direct(at, served, random, own, counts) + aids_->near.first()[texel]);
    }
  }
  Rgb stands_for{};
  if (depth >= kSureDepth) {
    // What the first stage has of the light stands for a walk that ends, and is taken off the
    // others: both means are right, and in even light ending makes no noise. Not for readers of
    // single directions, whose light must not be negative.
    const float survival = std::min(1.0f, reflectance.max());
    const bool ends = !(random.next_float() < survival);
    if (aids_ != nullptr && !through && !input_.lookup.is_split(e)) {
      stands_for = stand_for(e, path, reflectance * (ends ? 1.0f : 1 - 1 / survival));
    }
    if (ends) return stands_for;
    reflectance = reflectance * (1.0f / survival);
  }
  const Path own = path.further(reflectance);
  Rgb irradiance = direct(at, through ? radiosity::kNoElement : served, random, own, counts);
  const Vec3f direction =
      Frame::about(at.frame.normal).to_world(cosine_hemisphere(numbers.direction));
  const Numbers next{random.next_u64(), {random.next_float(), random.next_float()}};
  radiosity::walk_hemisphere_ray(
      input_.optics, input_.caster, {at.frame.origin, direction}, at.triangle, counts.rays,
      [&](const rays::Hit& further, const Rgb& weight) {
        irradiance += weight * seen(further, further.t, next, depth + 1, own.times(weight), counts);
      },
      [&](const Rgb& weight) {
        const Rgb sky = weight * input_.sky.radiance(direction) * kPi;
        irradiance += sky;
        if (own.grouped()) own.add(own.by_group.size() - 1, sky);
      });
  return reflectance * irradiance + stands_for;
}

Rgb Gather::seen(const rays::Hit& hit, float distance, const Numbers& numbers, int depth,
                 const Path& path, BakeCounts& counts) const {
  const ElementId e = input_.lookup.at(hit);
  if (e == radiosity::kNoElement) return {};
  const ElementId brings = served(hit, path);
  if (depth < kMaxDepth && distance < near_[e] * (depth == 0 ? 1.0f : kLaterReach)) {
    return gather_deeper(e, hit, brings, numbers, depth, path, counts);
  }
  return read(e, hit, brings, path, counts);
}

Gather::Along Gather::along(const rays::Ray& ray, std::uint32_t exclude, const Numbers& numbers,
                            const Path& path, BakeCounts& counts) const {
  Along result;
  radiosity::walk_hemisphere_ray(
      input_.optics, input_.caster, ray, exclude, counts.rays,
      [&](const rays::Hit& hit, const Rgb& weight) {
        if (result.inverse_distance == 0) {
          result.meets_back = hit.back && !input_.optics.has_two_sides(hit.triangle);
        }
        result.inverse_distance += 1.0 / std::max(1e-30, static_cast<double>(hit.t));
        result.radiosity +=
            to_double(weight * seen(hit, hit.t, numbers, 0, path.times(weight), counts));
      },
      [&](const Rgb& weight) {
        const Rgb sky = weight * input_.sky.radiance(ray.direction) * kPi;
        result.radiosity += to_double(sky);
        if (path.grouped()) path.add(path.by_group.size() - 1, sky);
      });
  return result;
}

Gather::Value Gather::operator()(const TexelPoints& points, int rays, std::uint32_t seed,
                                 std::span<Rgb> by_group, Scratch& scratch,
                                 BakeCounts& counts) const {
  scratch.links.clear();
  Receivers receivers(input_.scene, input_.layout, input_.direct.lift());
  Path path{{1, 1, 1}, by_group, nullptr, nullptr};
  radiosity::VirtualLights::ReceiverPatch centre;
  if (aids_ != nullptr) {
    path.links = &scratch.links;
    if (!aids_->lights.is_empty()) {
      centre = receiver_patch(points, receivers);
      path.receiver = &centre;
    }
  }
  const OwenSobol8 sequence(seed);
  Rgbd sum, first_half;
  double inverse_distance = 0;
  auto wanted = static_cast<std::uint32_t>(rays);
  std::uint32_t half = wanted / 2;
  const std::uint64_t before = counts.rays.cast();
  for (std::uint32_t k = 0; k < wanted; ++k) {
    if (k == kFirstRays) {
      wanted = worth_casting(rays, static_cast<double>(counts.rays.cast() - before) / kFirstRays);
      half = wanted / 2;
    }
    if (k == half) first_half = sum;
    const auto i = std::min(
        points.count - 1,
        static_cast<std::uint32_t>(sequence.coordinate(k, 2) * static_cast<float>(points.count)));
    const Receiver from = receivers(points.point[i], sequence.pair(k, 3));
    const Guide::Place place = scratch.guide.place(sequence.pair(k, 0));
    const Vec3f direction =
        Frame::about(from.frame.normal).to_world(cosine_hemisphere(place.square));
    const Numbers numbers{item_seed(seed, k), sequence.pair(k, 5)};
    const Along arrives = along({from.frame.origin, direction}, from.triangle, numbers,
                                path.times(Rgb::grey(place.weight)), counts);
    sum += arrives.radiosity * static_cast<double>(place.weight);
    inverse_distance += arrives.inverse_distance * static_cast<double>(place.weight);
    const auto brings = static_cast<float>(arrives.radiosity.sum());
    scratch.learned.squares[GuideGrid::cell(place.square)] += brings * brings * place.weight;
  }
  scratch.learned.rays += static_cast<float>(wanted);
  Value value;
  const auto taken = static_cast<double>(wanted);
  for (Rgb& part : by_group) part = part * static_cast<float>(1 / taken);
  for (NearLink& link : scratch.links) link.weight = link.weight * static_cast<float>(1 / taken);
  NearLinks::merge(scratch.links);
  VirtualTexel::Value from_virtual;
  if (aids_ != nullptr) {
    from_virtual = VirtualTexel(input_, aids_->lights)(
        points, centre,
        std::max(kFewestVirtual, static_cast<int>(static_cast<double>(rays) *
                                                  settings_.virtual_rays / settings_.rays)),
        static_cast<std::uint32_t>(item_seed(seed, 0, 1)), scratch.served, by_group, counts);
  }
  value.irradiance = to_float(sum / taken + from_virtual.irradiance);
  const double difference = ((sum - first_half) / (taken - static_cast<double>(half)) -
                             first_half / std::max(1.0, static_cast<double>(half)))
                                    .sum() /
                                3 +
                            from_virtual.difference;
  value.variance = static_cast<float>(difference * difference / 4);
  value.distance = inverse_distance > 0 ? static_cast<float>(taken / inverse_distance)
                                        : std::numeric_limits<float>::infinity();
  return value;
}

}  // namespace lightbatch::lightmap
