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

/// Irradiance from emitters where a ray hits an uneven element: from one of them at random.
/// deliver(group, lux).
template <typename Deliver>
Rgb uneven_irradiance(const scene::Scene& scene, const DirectLight& direct,
                      const Solution& solution, ElementId e, const rays::Hit& hit,
                      RayCounts& counts, Deliver deliver) {
  if (!solution.is_uneven(e)) return {};
  const Receiver at{
      optics::surface_frame(scene, hit.triangle, hit.u, hit.v, hit.back, direct.lift()),
      hit.triangle};
  const Vec2f on_emitter = random_at(hit);
  Random random(item_seed(hit.triangle, std::bit_cast<std::uint32_t>(hit.u) ^ 0x5bd1e995u,
                          std::bit_cast<std::uint32_t>(hit.v)));
  const auto sampled = direct.sampled_emitters(at, 0, random.next_double(), on_emitter, counts);
  deliver(sampled.group, sampled.irradiance);
  return sampled.irradiance;
}

/// Irradiance from the resolved lights where a ray hits element e, sharp: their formula where the
/// element is lit, a shadow ray where it is mixed. deliver(group, lux): each that arrives.
template <typename Deliver>
Rgb resolved_irradiance(const scene::Scene& scene, const DirectLight& direct,
                        const Solution& solution, ElementId e, const rays::Hit& hit,
                        RayCounts& counts, Deliver deliver) {
  if (solution.light_state.empty() || solution.light_state[e] == 0) return {};
  const Receiver at{
      optics::surface_frame(scene, hit.triangle, hit.u, hit.v, hit.back, direct.lift()),
      hit.triangle};
  Rgb sum;
  for_each_resolved(direct, solution, e, at.frame,
                    [&](const PunctualLight& light, const Rgb& open, bool doubtful) {
                      if (!doubtful) {
                        sum += open;
                        deliver(light.group, open);
                        return;
                      }
                      const Vec2f on_sun = light.is_of_sky() ? random_at(hit) : Vec2f{};
                      const Rgb arrives =
                          open * direct.punctual_visibility(at, light, on_sun, counts);
                      sum += arrives;
                      deliver(light.group, arrives);
                    });
  return sum;
}

}  // namespace lightbatch::radiosity
