#pragma once

#include "core/optics/surface_frame.h"
#include "core/radiosity/direct_light.h"
#include "core/radiosity/solution.h"
#include "core/rays/caster.h"

namespace lightbatch::radiosity {

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

/// Irradiance from the resolved lights where a ray hits element e, sharp: their formula where the
/// element is lit, a shadow ray where it is mixed. deliver(light, lux): each that arrives.
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
                      const Rgb arrives =
                          doubtful ? open * direct.punctual_visibility(at, light, counts) : open;
                      sum += arrives;
                      deliver(light, arrives);
                    });
  return sum;
}

}  // namespace lightbatch::radiosity
