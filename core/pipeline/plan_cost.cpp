#include "core/pipeline/plan_cost.h"

#include <algorithm>

namespace lightbatch::pipeline {
namespace {

using plan::Effect;

/// Texels of the pilot, about: shares need no more.
constexpr double kPilotTexels = 500;

}  // namespace

void set_costs(plan::EffectPlan& effects, const scene::Scene& scene, const LightBake& bake,
               double baked_share) {
  const auto rays_of = [&](std::uint64_t radiosity::RayCounts::*count) {
    const auto of_texels = static_cast<double>(bake.baked.counts.rays.*count) +
                           static_cast<double>(bake.directional.counts.rays.*count);
    return static_cast<double>(bake.radiosity.rays.*count) +
           static_cast<double>(bake.probes.counts.rays.*count) +
           of_texels / std::max(1e-9, baked_share);
  };
  using radiosity::RayCounts;
  const double punctual = rays_of(&RayCounts::punctual_shadow);
  const double suns = rays_of(&RayCounts::sun_shadow);
  const double emitter = rays_of(&RayCounts::emitter_shadow);
  const double hemisphere = rays_of(&RayCounts::hemisphere);
  // A hemisphere ray serves the sky when it escapes to one, else what surfaces reflect.
  const double to_sky = !effects.on(Effect::kSky)              ? 0
                        : effects.on(Effect::kInterreflection) ? rays_of(&RayCounts::sky_escapes)
                                                               : hemisphere;
  const double crossings = rays_of(&RayCounts::sheet_crossings);
  const double all = punctual + suns + emitter + hemisphere;
  if (!(all > 0)) return;
  const auto set = [&](Effect effect, double rays) {
    if (effects.on(effect)) effects[effect].cost_share = std::min(1.0, rays / all);
  };
  const auto lights = [&](scene::LightKind kind) {
    const auto count = std::count_if(scene.lights.begin(), scene.lights.end(),
                                     [&](const scene::Light& l) { return l.kind == kind; });
    return static_cast<double>(count) /
           static_cast<double>(std::max<std::size_t>(1, scene.lights.size()));
  };
  set(Effect::kPointLights, punctual * lights(scene::LightKind::kPoint));
  set(Effect::kSpotLights, punctual * lights(scene::LightKind::kSpot));
  set(Effect::kDirectionalLights, punctual * lights(scene::LightKind::kDirectional));
  set(Effect::kEmitters, emitter);
  set(Effect::kShadows, punctual + emitter);
  set(Effect::kSky, to_sky + suns);
  set(Effect::kInterreflection, hemisphere - std::min(to_sky, hemisphere));
  set(Effect::kAlphaCutout, rays_of(&RayCounts::alpha_lookups));
  set(Effect::kAlphaBlend, crossings);
  set(Effect::kTransmission, crossings);
  set(Effect::kDirectionalLightmaps,
      static_cast<double>(bake.directional.counts.rays.cast()) / std::max(1e-9, baked_share));
  set(Effect::kProbes, static_cast<double>(bake.probes.counts.rays.cast()));
}

Status expect_costs(const JobOptions& options, Prepared& p, StageClock& clock,
                    const Progress& progress) {
  LB_ASSIGN_OR_RETURN(const LightmapPlaces places, make_places(options, p, clock, progress));
  const std::size_t texels = places.texels.texels.size();
  if (texels == 0) return {};
  const auto settings =
      accuracy::settings_for(p.target_error, measure_for_settings(p, places), options.seed);
  const std::vector<std::uint8_t> selected = lightmap::select_texels(
      places.layout, places.texels, 8,
      static_cast<std::uint32_t>(std::max(1.0, static_cast<double>(texels) / kPilotTexels)));
  const auto baked = std::count(selected.begin(), selected.end(), 1);
  if (baked == 0) return {};
  clock.start("pilot");
  progress.report("pilot", 0);
  StageClock own;
  LB_ASSIGN_OR_RETURN(const LightBake bake, bake_light(options, p, places, settings, own, progress,
                                                       {&selected, false, nullptr}));
  clock.stop();
  set_costs(p.effects, *p.scene, bake, static_cast<double>(baked) / static_cast<double>(texels));
  return {};
}

}  // namespace lightbatch::pipeline
