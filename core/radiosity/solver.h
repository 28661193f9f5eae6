#pragma once

#include "core/base/progress.h"
#include "core/base/status.h"
#include "core/optics/environment.h"
#include "core/radiosity/direct_light.h"
#include "core/radiosity/element_lookup.h"
#include "core/radiosity/elements.h"
#include "core/radiosity/solution.h"
#include "core/rays/caster.h"

namespace lightbatch::radiosity {

/// What both modes of the first stage take.
struct SolverInput {
  const scene::Scene& scene;
  const hierarchy::Hierarchy& tree;
  const optics::Optics& optics;
  const rays::Caster& caster;
  const Elements& elements;
  const DirectLight& direct;
  const optics::Environment& sky;
  const ElementLookup& lookup;
  /// Light groups to keep apart, the sky's last (there even when the sky is black); 0: none.
  std::size_t groups = 0;
};

struct SolverOptions {
  int rays = 16;                // stored rays per element of full size
  int direct_samples = 8;       // points per element that direct light is measured at
  double threshold = 1e-4;      // linked mode: share of the emitted flux below which a link is kept
  double tolerance = 1e-4;      // of the iteration: relative change at which it stops
  bool interreflection = true;  // off: direct and sky light only
  std::uint64_t seed = 1;
};

/// Stored-ray mode: every element shoots cosine rays once, the hits are its links, and the system
/// is solved on them. CANCELLED, or INPUT_OVER_BUDGET when the links would not fit.
Result<Solution> solve_stored_rays(const SolverInput& input, const SolverOptions& options,
                                   const Progress& progress);

/// The common part: irradiance from lights, emitters of every element, and the state of the
/// resolved lights (fills irradiance, unresolved, resolved, light_state with direct light only;
/// radiosity stays empty).
/// direct_by_group, where groups are asked: direct light, lux, per element; unresolved_by_group
/// then holds that of the lights that are not resolved.
Solution measure_direct(const SolverInput& input, const SolverOptions& options,
                        const Progress& progress, GroupedLight* direct_by_group = nullptr);

}  // namespace lightbatch::radiosity
