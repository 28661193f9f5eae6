#pragma once

#include <algorithm>

#include "core/optics/environment.h"
#include "core/optics/optics.h"
#include "core/radiosity/direct_light.h"
#include "core/rays/caster.h"

namespace lightbatch::radiosity {

/// Sheets one ray may cross; what is left after that many is taken as absorbed.
constexpr int kMaxSheets = 64;

/// Follows a ray through sheets to what stops it. meet(hit, weight) is called for every surface
/// met (sheets and the last one), escape(weight) when the ray leaves the scene. weight:
/// transmittance of the sheets before times the coverage of the surface met; all weights of a ray
/// add up to at most 1, so that no element takes more than all of what it sees.
template <typename Meet, typename Escape>
void walk_hemisphere_ray(const optics::Optics& optics, const rays::Caster& caster, rays::Ray ray,
                         std::uint32_t exclude, RayCounts& counts, Meet meet, Escape escape) {
  ++counts.hemisphere;
  if (optics.filtered_count() == 0) {
    const rays::Hit hit = caster.closest(ray, exclude);
    if (hit.found()) {
      meet(hit, Rgb{1, 1, 1});
    } else {
      ++counts.sky_escapes;
      escape(Rgb{1, 1, 1});
    }
    return;
  }
  Rgb weight{1, 1, 1};
  for (int crossed = 0; crossed < kMaxSheets; ++crossed) {
    optics::ClosestFilter filter(optics);
    const rays::Hit hit = caster.closest(ray, exclude, &filter);
    counts.alpha_lookups += filter.asked();
    if (!hit.found()) {
      ++counts.sky_escapes;
      escape(weight);
      return;
    }
    if (!optics.sheet(hit.triangle)) {
      meet(hit, weight);
      return;
    }
    const auto sheet = optics.scatterer(hit.triangle, hit.u, hit.v);
    if (sheet.coverage > 0) meet(hit, weight * sheet.coverage);
    weight *= sheet.transmittance;
    if (weight.is_black()) return;
    ++counts.sheet_crossings;
    exclude = hit.triangle;
    ray.t_min = hit.t;
  }
}

}  // namespace lightbatch::radiosity
