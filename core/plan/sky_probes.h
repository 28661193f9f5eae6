#pragma once

#include "core/optics/optics.h"
#include "core/rays/caster.h"
#include "core/scene/scene.h"

namespace lightbatch::plan {

struct SkyProbes {
  int cast = 0;
  int escaped = 0;
};

/// Rays that look for a way out, until one is found: from every side of surfaces that light can
/// leave, drawn in turn by area, by triangle and by object, so that neither dense nor large parts
/// hide the others.
SkyProbes probe_surfaces(const scene::Scene& scene, const optics::Optics& optics,
                         const rays::Caster& caster);

/// The same from where moving meshes can be.
SkyProbes probe_moving(const scene::Scene& scene, const optics::Optics& optics,
                       const rays::Caster& caster);

}  // namespace lightbatch::plan
