#pragma once

#include "core/optics/surface_frame.h"
#include "core/radiosity/direct_light.h"
#include "core/radiosity/solution.h"
#include "core/rays/caster.h"

namespace lightbatch::radiosity {

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
  for (std::size_t k = 0; k < solution.resolved.size(); ++k) {
    const LightState state = solution.state(e, k);
    if (state == LightState::kDark) continue;
    const PunctualLight& light = direct.sources().punctual()[solution.resolved[k]];
    const Rgb open = light.irradiance(at.frame.position, at.frame.normal);
    if (open.is_black()) continue;
    const Rgb arrives =
        state == LightState::kLit ? open : open * direct.punctual_visibility(at, light, counts);
    sum += arrives;
    deliver(light, arrives);
  }
  return sum;
}

}  // namespace lightbatch::radiosity
