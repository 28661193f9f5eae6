#pragma once

#include "core/pipeline/light_stage.h"

namespace lightbatch::pipeline {

/// Fills cost_share of the effect plan: the share of all rays that is cast for an effect, each ray
/// counted as often as it serves one. `bake` may be a pilot: of its texels, `baked_share` of all.
void set_costs(plan::EffectPlan& effects, const scene::Scene& scene, const LightBake& bake,
               double baked_share = 1.0);

/// set_costs() from a pilot bake of a few texels at p.target_error. Stages "charts", "texels",
/// "pilot". A scene without texels keeps shares of 0.
Status expect_costs(const JobOptions& options, Prepared& p, StageClock& clock,
                    const Progress& progress);

}  // namespace lightbatch::pipeline
