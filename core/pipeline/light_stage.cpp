#include "core/pipeline/light_stage.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/pipeline/directional_stage.h"
#include "core/pipeline/first_stage.h"
#include "core/pipeline/probe_stage.h"

namespace lightbatch::pipeline {
namespace {

template <typename Weight>
double area_of(const scene::Scene& scene, Weight weight) {
  return deterministic_reduce(
      scene.triangles.size(), 16384, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) {
          const auto triangle = static_cast<std::uint32_t>(i);
          sum += weight(triangle) * scene.area(triangle);
        }
        return sum;
      },
      [](double a, double b) { return a + b; });
}

/// Mean irradiance over the surfaces that have texels, all channels.
double mean_over_texels(const Prepared& p, const LightmapPlaces& places, const FirstStage& first) {
  double sum = 0, area = 0;
  for (std::uint32_t i = 0; i < p.scene->triangles.size(); ++i) {
    const std::uint32_t chart = places.layout.chart_of[i];
    if (chart == scene::kNone) continue;
    const double a = p.scene->area(i);
    sum += first.irradiance_of(i, places.texels.is_back(chart)) * a;
    area += a;
  }
  return area > 0 ? sum / area : 0;
}

/// Light in front of a chart below this share of that behind: the front is closed off.
constexpr double kClosedOff = 0.002;
/// Nominal error of the first stage that tells: only light and darkness are asked.
constexpr double kRoughRung = 0.1;

/// Two-sided surfaces have one texel for two sides: the front's, but the back's where no light can
/// reach the front of a whole chart, as in a closed slab that is modelled inside out. Viewers flip
/// the normal of what they see of a two-sided surface (glTF 2.0, material.doubleSided), so the side
/// that is seen is the one that has light.
Status choose_sides(const JobOptions& options, const Prepared& p, LightmapPlaces& places,
                    const Progress& progress) {
  bool any = false;
  for (std::uint32_t i = 0; i < p.scene->triangles.size() && !any; ++i) {
    any = places.layout.chart_of[i] != scene::kNone && p.optics->double_sided(i);
  }
  if (!any) return {};
  FirstStage first(
      options, p,
      accuracy::settings_for(kRoughRung, measure_for_settings(p, places), options.seed));
  LB_RETURN_IF_ERROR(first.solve(p, SolverMode::kStoredRay, 0, progress));
  std::vector<double> front(places.layout.charts.size()), behind(front.size());
  std::vector<std::uint8_t> one_sided(front.size());
  for (std::uint32_t i = 0; i < p.scene->triangles.size(); ++i) {
    const std::uint32_t chart = places.layout.chart_of[i];
    if (chart == scene::kNone) continue;
    if (!p.optics->double_sided(i)) {
      one_sided[chart] = 1;
      continue;
    }
    const double area = p.scene->area(i);
    front[chart] += area * first.irradiance_of(i, false);
    behind[chart] += area * first.irradiance_of(i, true);
  }
  places.texels.back.assign(front.size(), 0);
  for (std::size_t c = 0; c < front.size(); ++c) {
    if (one_sided[c] == 0 && front[c] < kClosedOff * behind[c]) places.texels.back[c] = 1;
  }
  return {};
}

}  // namespace

accuracy::SceneMeasure measure_for_settings(const Prepared& p, const LightmapPlaces& places) {
  return {
      area_of(*p.scene, [&](std::uint32_t i) { return p.optics->has_two_sides(i) ? 2.0 : 1.0; }),
      places.texels.texels.size()};
}

Result<LightmapPlaces> make_places(const JobOptions& options, const Prepared& p, StageClock& clock,
                                   const Progress& progress) {
  clock.start("charts");
  progress.report("charts", 0);
  std::vector<std::uint8_t> lit(p.scene->triangles.size());
  for (std::uint32_t i = 0; i < lit.size(); ++i) {
    lit[i] = p.scene->material_of(i).unlit ? 0 : 1;
  }
  atlas::LayoutOptions layout_options;
  layout_options.texels_per_metre = options.texels_per_metre;
  layout_options.page_size = options.lightmap_size;
  LightmapPlaces places;
  LB_ASSIGN_OR_RETURN(places.layout, atlas::make_layout(*p.scene, lit, layout_options, progress));
  clock.start("texels");
  places.texels = atlas::cover_texels(*p.scene, places.layout);
  LB_RETURN_IF_ERROR(choose_sides(options, p, places, progress));
  clock.stop();
  return places;
}

Result<LightBake> bake_light(const JobOptions& options, const Prepared& p,
                             const LightmapPlaces& places, const accuracy::BakeSettings& settings,
                             StageClock& clock, const Progress& progress, const LightWish& wish) {
  clock.start("radiosity");
  progress.report("radiosity", 0);
  LightBake bake;
  std::shared_ptr<const FirstStage> first = wish.first;
  const bool whole = wish.selected == nullptr;
  if (first == nullptr) {
    const auto fresh = std::make_shared<FirstStage>(options, p, settings);
    const std::size_t most = whole || wish.keep_first ? places.texels.texels.size() : 0;
    LB_RETURN_IF_ERROR(fresh->solve(p, options.solver, most, progress));
    first = fresh;
  }
  bake.settings = settings;
  bake.settings.elements = first->settings.elements;
  bake.settings.solver = first->settings.solver;
  bake.element_edge = first->elements.edge();
  bake.mode = first->linked ? "linked" : "stored-ray";
  bake.radiosity = first->solution.statistics;
  bake.mean_irradiance = mean_over_texels(p, places, *first);
  if (whole) bake.groups = first->groups;
  if (wish.keep_first) bake.first = first;

  clock.start("gather");
  bake.stage_seconds = clock.stages().back().seconds;
  lightmap::BakeInput input{*p.scene,      *p.optics,       *p.caster,     p.sky,
                            first->direct, first->elements, first->lookup, first->solution,
                            places.layout, places.texels};
  input.indirect = first->options.interreflection || !p.sky.is_black();
  input.punctual_direct = options.lights == LightsPolicy::kRemove;
  input.direct_lights = !first->sources.punctual().empty() || !first->sources.emitters().empty();
  input.mean_irradiance = bake.mean_irradiance;
  input.groups = whole ? first->solution.unresolved_by_group.groups() : 0;
  input.seed = options.seed;
  input.selected = wish.selected;
  LB_ASSIGN_OR_RETURN(bake.baked, lightmap::bake_texels(input, settings.gather, progress));
  clock.stop();
  bake.texel_seconds = clock.stages().back().seconds;
  if (p.effects.on(plan::Effect::kDirectionalLightmaps)) {
    LB_ASSIGN_OR_RETURN(bake.directional,
                        bake_directional_lightmaps(p, input, settings.gather, clock, progress));
    bake.directional_seconds = clock.stages().back().seconds;
  }
  if (whole && p.effects.on(plan::Effect::kProbes)) {
    LB_ASSIGN_OR_RETURN(bake.probes, bake_light_probes(p, input, settings.gather, clock, progress));
  }
  return bake;
}

double mean_of_map(const LightmapPlaces& places, const LightBake& light) {
  double sum = 0, area = 0;
  for (std::size_t t = 0; t < places.texels.texels.size(); ++t) {
    const double surface = places.texels.surface_of(places.texels.texels[t]);
    sum += surface * static_cast<double>(light.baked.irradiance[t].sum()) / 3.0;
    area += surface;
  }
  return area > 0 ? sum / area : 0;
}

}  // namespace lightbatch::pipeline
