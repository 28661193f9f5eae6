#pragma once

#include <bit>

#include "core/base/random.h"
#include "core/optics/surface_frame.h"
#include "core/radiosity/direct_light.h"
#include "core/radiosity/solution.h"
#include "core/rays/caster.h"

namespace lightbatch::radiosity {

/// Reflectance at a point of an element: its own where it varies on the triangle, as on a bright
/// spot of a texture in the sun.
inline Rgb reflectance_at(const optics::Optics& optics, const Elements& elements, ElementId e,
                          std::uint32_t triangle, float u, float v) {
  return optics.textured_reflectance(triangle) ? optics.scatterer(triangle, u, v).reflectance
                                               : elements.reflectance(e);
}

/// Calls deliver(light, lux, doubtful) for the resolved lights that may reach a point on element
/// e; lux: with nothing between; doubtful: the element is mixed, so that something may be.
template <typename Deliver>
void for_each_resolved(const DirectLight& direct, const Solution& solution, ElementId e,
                       const optics::SurfaceFrame& at, Deliver deliver) {
  for (std::size_t k = 0; k < solution.resolved.size(); ++k) {
    const LightState state = solution.state(e, k);
    if (state == LightState::kDark) continue;
    const PunctualLight& light = direct.sources().punctual()[solution.resolved[k]];
    const Rgb open = light.irradiance(at.position, at.normal);
    if (!open.is_black()) deliver(light, open, state == LightState::kMixed);
  }
}

/// Two numbers in [0, 1) that differ from hit to hit.
inline Vec2f random_at(const rays::Hit& hit) {
  Random random(item_seed(hit.triangle, std::bit_cast<std::uint32_t>(hit.u),
                          std::bit_cast<std::uint32_t>(hit.v)));
  return {random.next_float(), random.next_float()};
}

/// Whether `unresolved` leaves out some of an element's light.
inline bool has_resolved(const Solution& solution, ElementId e) {
  return solution.is_uneven(e) || (!solution.light_state.empty() && solution.light_state[e] != 0);
}

/// Irradiance where a ray hits element e of what `unresolved` leaves out, sharp: from emitters, by
/// one of them at random, where the element is uneven; from the resolved lights, unless told not
/// to, by their formula where the element is lit and a shadow ray where it is mixed.
/// deliver(group, lux): each that arrives.
template <typename Deliver>
Rgb sharp_irradiance(const scene::Scene& scene, const DirectLight& direct, const Solution& solution,
                     ElementId e, const rays::Hit& hit, bool with_resolved, RayCounts& counts,
                     Deliver deliver) {
  const bool uneven = solution.is_uneven(e);
  with_resolved = with_resolved && !solution.light_state.empty() && solution.light_state[e] != 0;
  if (!uneven && !with_resolved) return {};
  const Receiver at{
      optics::surface_frame(scene, hit.triangle, hit.u, hit.v, hit.back, direct.lift()),
      hit.triangle};
  Rgb emitted, resolved;
  if (uneven) {
    Random random(item_seed(hit.triangle, std::bit_cast<std::uint32_t>(hit.u) ^ 0x5bd1e995u,
                            std::bit_cast<std::uint32_t>(hit.v)));
    const auto sampled =
        direct.sampled_emitters(at, 0, random.next_double(), random_at(hit), counts);
    deliver(sampled.group, sampled.irradiance);
    emitted = sampled.irradiance;
  }
  if (with_resolved) {
    for_each_resolved(direct, solution, e, at.frame,
                      [&](const PunctualLight& light, const Rgb& open, bool doubtful) {
                        Rgb arrives = open;
                        if (doubtful) {
                          const Vec2f on_sun = light.is_of_sky() ? random_at(hit) : Vec2f{};
                          arrives = open * direct.punctual_visibility(at, light, on_sun, counts);
                        }
                        resolved += arrives;
                        deliver(light.group, arrives);
                      });
  }
  return emitted + resolved;
}

}  // namespace lightbatch::radiosity
