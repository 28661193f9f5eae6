#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/gltf/document.h"
#include "core/hierarchy/hierarchy.h"
#include "core/hierarchy/statistics.h"
#include "core/optics/environment.h"
#include "core/optics/optics.h"
#include "core/optics/sky_suns.h"
#include "core/pipeline/job.h"
#include "core/pipeline/stage_clock.h"
#include "core/plan/effect_plan.h"
#include "core/rays/caster.h"
#include "core/scene/scene.h"

namespace lightbatch::pipeline {

/// What every kind of job starts from: the scene read, its hierarchy, its effect plan.
struct Prepared {
  gltf::Document document;
  std::unique_ptr<scene::Scene> scene;
  hierarchy::Hierarchy tree;
  hierarchy::Statistics tree_statistics;
  double tree_seconds = 0;
  std::unique_ptr<optics::Optics> optics;
  optics::Environment sky;  // without its suns: what rays over the hemisphere meet
  optics::Environment whole_sky;
  std::vector<optics::SkySun> suns;
  std::unique_ptr<rays::Caster> caster;
  plan::EffectPlan effects;
  double target_error = 0.02;
};

/// Stages "read", "hierarchy" and "plan". A bake without lightmaps has no optics, caster and
/// effects. Errors of the input and its options.
Result<Prepared> prepare(const JobOptions& options, const JobInput& input, StageClock& clock,
                         const Progress& progress);

}  // namespace lightbatch::pipeline
