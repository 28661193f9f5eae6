#pragma once

#include <vector>

#include "core/math/rgb.h"
#include "core/radiosity/elements.h"
#include "core/radiosity/solution.h"

namespace lightbatch::radiosity {

/// What comes diffusely through an element from behind: tau E_behind. lux(element): irradiance.
template <typename Lux>
Rgbd sent_through(const Elements& elements, ElementId e, const Lux& lux) {
  if (!elements.transmits() || elements.transmittance(e).is_black()) return {};
  Rgbd behind;
  elements.for_each_behind(
      e, [&](ElementId o, float share) { behind += lux(o) * static_cast<double>(share); });
  return to_double(elements.transmittance(e)) * behind;
}

/// What leaves an element of the light that arrives at it and behind it: rho E + tau E_behind.
template <typename Lux>
Rgbd sent_back(const Elements& elements, ElementId e, const Lux& lux) {
  return to_double(elements.reflectance(e)) * lux(e) + sent_through(elements, e, lux);
}

/// 1 - rho - tau: light is absorbed where it arrives, also what passes through.
inline Rgbd absorbed_share(const Elements& elements, ElementId e) {
  return Rgbd{1, 1, 1} - to_double(elements.reflectance(e) + elements.transmittance(e));
}

/// Irradiance by element, as the two above take it.
inline auto lux_of(const std::vector<Rgb>& irradiance) {
  return [&irradiance](ElementId e) { return to_double(irradiance[e]); };
}

/// Adds what comes through elements to `unresolved`, from the finished irradiance. Shadows of
/// resolved lights behind an element are as sharp as the element.
inline void add_through(const Elements& elements, Solution& solution) {
  if (!elements.transmits()) return;
  for (ElementId e = 0; e < elements.count(); ++e) {
    solution.unresolved[e] += to_float(sent_through(elements, e, lux_of(solution.irradiance)));
  }
}

}  // namespace lightbatch::radiosity
