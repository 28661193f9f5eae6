#include "core/lightmap/gather.h"

#include <cmath>
#include <limits>

#include "core/base/random.h"
#include "core/math/sampling.h"
#include "core/math/sobol.h"
#include "core/radiosity/hemisphere_walk.h"

namespace lightbatch::lightmap {
namespace {

using radiosity::ElementId;
using radiosity::LightState;
using radiosity::Receiver;

constexpr int kMaxDepth = 2;
/// Emitter terms of a point that is itself one sample of many.
constexpr std::size_t kDeepTerms = 6;

}  // namespace

Rgb Gather::read(ElementId e, const rays::Hit& hit, BakeCounts& counts) const {
  const radiosity::Solution& solution = input_.solution;
  if (solution.light_state.empty()) return solution.radiosity[e];
  const std::uint16_t states = solution.light_state[e];
  if (states == 0) return solution.unresolved[e];
  const Receiver at{optics::surface_frame(input_.scene, hit.triangle, hit.u, hit.v, hit.back,
                                          input_.direct.lift()),
                    hit.triangle};
  Rgb direct{};
  for (std::size_t k = 0; k < solution.resolved.size(); ++k) {
    const LightState state = solution.state(e, k);
    if (state == LightState::kDark) continue;
    const auto& light = input_.direct.sources().punctual()[solution.resolved[k]];
    const Rgb open = light.irradiance(at.frame.position, at.frame.normal);
    if (open.is_black()) continue;
    direct += state == LightState::kLit
                  ? open
                  : open * input_.direct.punctual_visibility(at, light, counts.rays);
  }
  return solution.unresolved[e] + input_.elements.reflectance(e) * direct;
}

Rgb Gather::gather_deeper(ElementId e, const rays::Hit& hit, std::uint64_t seed, int depth,
                          BakeCounts& counts) const {
  ++counts.deeper_gathers;
  const Receiver at{optics::surface_frame(input_.scene, hit.triangle, hit.u, hit.v, hit.back,
                                          input_.direct.lift()),
                    hit.triangle};
  Random random(seed);
  Rgb irradiance{};
  for (const auto& light : input_.direct.sources().punctual()) {
    const Rgb open = light.irradiance(at.frame.position, at.frame.normal);
    if (!open.is_black()) {
      irradiance += open * input_.direct.punctual_visibility(at, light, counts.rays);
    }
  }
  const auto terms = input_.direct.emitter_terms(at, random.next_u64(), counts.rays, kDeepTerms);
  if (terms.count > 0) {
    irradiance +=
        terms.total *
        input_.direct.emitter_visibility(at, terms, 1, 0, random.next_u32(), counts.rays).share();
  }
  const Vec3f direction =
      Frame::about(at.frame.normal)
          .to_world(cosine_hemisphere({random.next_float(), random.next_float()}));
  const std::uint64_t next = random.next_u64();
  radiosity::walk_hemisphere_ray(
      input_.optics, input_.caster, {at.frame.origin, direction}, at.triangle, counts.rays,
      [&](const rays::Hit& further, const Rgb& weight) {
        irradiance += weight * seen(further, further.t, next, depth + 1, counts);
      },
      [&](const Rgb& weight) { irradiance += weight * input_.sky.radiance(direction) * kPi; });
  return input_.elements.reflectance(e) * irradiance;
}

Rgb Gather::seen(const rays::Hit& hit, float distance, std::uint64_t seed, int depth,
                 BakeCounts& counts) const {
  const ElementId e = input_.lookup.at(hit);
  if (e == radiosity::kNoElement) return {};
  if (depth < kMaxDepth &&
      static_cast<double>(distance) < settings_.deeper * input_.elements.edge()) {
    return gather_deeper(e, hit, mix_bits(seed ^ hit.triangle), depth, counts);
  }
  return read(e, hit, counts);
}

Gather::Value Gather::operator()(const TexelPoints& points, int rays, std::uint32_t seed,
                                 BakeCounts& counts) const {
  std::array<Receiver, 16> receiver;
  std::array<Frame, 16> frame;
  for (std::uint32_t i = 0; i < points.count; ++i) {
    receiver[i] = receiver_at(input_.scene, input_.layout, points.point[i], input_.direct.lift());
    frame[i] = Frame::about(receiver[i].frame.normal);
  }
  const OwenSobol8 sequence(seed);
  Rgbd sum;
  double inverse_distance = 0;
  for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(rays); ++k) {
    const auto i = std::min(
        points.count - 1,
        static_cast<std::uint32_t>(sequence.coordinate(k, 2) * static_cast<float>(points.count)));
    const Vec3f direction = frame[i].to_world(cosine_hemisphere(sequence.pair(k, 0)));
    radiosity::walk_hemisphere_ray(
        input_.optics, input_.caster, {receiver[i].frame.origin, direction}, receiver[i].triangle,
        counts.rays,
        [&](const rays::Hit& hit, const Rgb& weight) {
          inverse_distance += 1.0 / std::max(1e-30, static_cast<double>(hit.t));
          sum += to_double(weight * seen(hit, hit.t, item_seed(seed, k), 0, counts));
        },
        [&](const Rgb& weight) {
          sum += to_double(weight * input_.sky.radiance(direction) * kPi);
        });
  }
  Value value;
  value.irradiance = to_float(sum / static_cast<double>(rays));
  value.distance = inverse_distance > 0 ? static_cast<float>(rays / inverse_distance)
                                        : std::numeric_limits<float>::infinity();
  return value;
}

}  // namespace lightbatch::lightmap
