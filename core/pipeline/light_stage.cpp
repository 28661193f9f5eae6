#include "core/pipeline/light_stage.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/radiosity/direct_light.h"
#include "core/radiosity/elements.h"
#include "core/radiosity/light_sources.h"
#include "core/radiosity/linked_solver.h"
#include "core/radiosity/solver.h"

namespace lightbatch::pipeline {
namespace {

using plan::Effect;

double triangle_area(const scene::Scene& scene, std::uint32_t i) {
  const auto c = scene.corners(i);
  const Vec3d a = to_double(c[0]);
  return 0.5 * length(cross(to_double(c[1]) - a, to_double(c[2]) - a));
}

template <typename Weight>
double area_of(const scene::Scene& scene, Weight weight) {
  return deterministic_reduce(
      scene.triangles.size(), 16384, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) {
          const auto triangle = static_cast<std::uint32_t>(i);
          sum += weight(triangle) * triangle_area(scene, triangle);
        }
        return sum;
      },
      [](double a, double b) { return a + b; });
}

/// All that the first stage is made of; the parts refer to each other.
struct FirstStage {
  radiosity::LightSources sources;
  radiosity::DirectLight direct;
  radiosity::Elements elements;
  radiosity::ElementLookup lookup;
  radiosity::SolverOptions options;
  radiosity::Solution solution;

  FirstStage(const Prepared& p, const accuracy::BakeSettings& settings)
      : sources(*p.scene, *p.optics,
                {p.effects.on(Effect::kPointLights), p.effects.on(Effect::kSpotLights),
                 p.effects.on(Effect::kDirectionalLights), p.effects.on(Effect::kEmitters)}),
        direct(*p.optics, *p.caster, sources, p.effects.on(Effect::kShadows)),
        elements(*p.scene, p.tree, *p.optics, settings.elements),
        lookup(*p.scene, *p.caster, elements, direct.lift()),
        options(settings.solver) {
    options.interreflection = p.effects.on(Effect::kInterreflection);
  }
  FirstStage(const FirstStage&) = delete;
  FirstStage& operator=(const FirstStage&) = delete;

  Status solve(const Prepared& p, bool linked, std::size_t groups, const Progress& progress) {
    const radiosity::SolverInput input{*p.scene, p.tree, *p.optics, *p.caster, elements,
                                       direct,   p.sky,  lookup,    groups};
    LB_ASSIGN_OR_RETURN(solution, linked ? radiosity::solve_linked(input, options, progress)
                                         : radiosity::solve_stored_rays(input, options, progress));
    return {};
  }

  /// Mean irradiance of one side of a triangle, lux, mean over channels. Cells of large triangles:
  /// a fixed spread of points stands for them.
  double irradiance_of(std::uint32_t triangle, bool back) const {
    constexpr float kSpread[][2] = {{0.333f, 0.333f}, {0.1f, 0.1f},  {0.8f, 0.1f}, {0.1f, 0.8f},
                                    {0.45f, 0.45f},   {0.1f, 0.45f}, {0.45f, 0.1f}};
    double mean = 0;
    for (const auto& uv : kSpread) {
      const radiosity::ElementId e = elements.at(triangle, uv[0], uv[1], back);
      if (e == radiosity::kNoElement) continue;
      mean += static_cast<double>(solution.irradiance[e].sum()) / (3.0 * std::size(kSpread));
    }
    return mean;
  }
};

/// Mean irradiance over the surfaces that have texels, all channels.
double mean_over_texels(const Prepared& p, const LightmapPlaces& places, const FirstStage& first) {
  double sum = 0, area = 0;
  for (std::uint32_t i = 0; i < p.scene->triangles.size(); ++i) {
    const std::uint32_t chart = places.layout.chart_of[i];
    if (chart == scene::kNone) continue;
    const double a = triangle_area(*p.scene, i);
    sum += first.irradiance_of(i, places.texels.is_back(chart)) * a;
    area += a;
  }
  return area > 0 ? sum / area : 0;
}

/// Memory that light by group may take.
constexpr std::uint64_t kMostGroupedBytes = std::uint64_t{1} << 30;

/// Of the lights and the sky.
std::vector<radiosity::LightGroup> groups_of(const radiosity::LightSources& sources) {
  std::vector<radiosity::LightGroup> groups = sources.groups();
  groups.push_back({radiosity::LightGroup::Kind::kSky, 0, "sky", {1, 1, 1}});
  return groups;
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
      p, accuracy::settings_for(kRoughRung, measure_for_settings(p, places), options.seed));
  LB_RETURN_IF_ERROR(first.solve(p, false, 0, progress));
  std::vector<double> front(places.layout.charts.size()), behind(front.size());
  std::vector<std::uint8_t> one_sided(front.size());
  for (std::uint32_t i = 0; i < p.scene->triangles.size(); ++i) {
    const std::uint32_t chart = places.layout.chart_of[i];
    if (chart == scene::kNone) continue;
    if (!p.optics->double_sided(i)) {
      one_sided[chart] = 1;
      continue;
    }
    const double area = triangle_area(*p.scene, i);
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
  return {area_of(*p.scene, [&](std::uint32_t i) { return p.optics->double_sided(i) ? 2.0 : 1.0; }),
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
                             StageClock& clock, const Progress& progress,
                             const std::vector<std::uint8_t>* selected) {
  clock.start("radiosity");
  progress.report("radiosity", 0);
  LightBake bake;
  bake.settings = settings;
  FirstStage first(p, settings);
  bake.element_edge = first.elements.edge();
  const bool linked = options.solver == SolverMode::kLinked;
  if (selected == nullptr) bake.groups = groups_of(first.sources);
  const std::size_t sources = bake.groups.size() - (p.sky.is_black() ? 1 : 0);
  std::size_t apart = selected == nullptr && sources > 1 ? bake.groups.size() : 0;
  const std::uint64_t items =
      std::max<std::uint64_t>(places.texels.texels.size(), first.elements.count());
  if (apart > 0 && (linked || 4 * apart * items * sizeof(Rgb) > kMostGroupedBytes)) {
    apart = 0;
    bake.groups.clear();
  }
  LB_RETURN_IF_ERROR(first.solve(p, linked, apart, progress));
  bake.mode = linked ? "linked" : "stored-ray";
  bake.radiosity = first.solution.statistics;
  bake.mean_irradiance = mean_over_texels(p, places, first);

  clock.start("gather");
  lightmap::BakeInput input{*p.scene,      *p.optics,      *p.caster,    p.sky,
                            first.direct,  first.elements, first.lookup, first.solution,
                            places.layout, places.texels};
  input.indirect = first.options.interreflection || !p.sky.is_black();
  input.punctual_direct = options.lights == LightsPolicy::kRemove;
  input.direct_lights = !first.sources.punctual().empty() || !first.sources.emitters().empty();
  input.mean_irradiance = bake.mean_irradiance;
  input.groups = apart;
  input.seed = options.seed;
  input.selected = selected;
  LB_ASSIGN_OR_RETURN(bake.baked, lightmap::bake_texels(input, settings.gather, progress));
  clock.stop();
  return bake;
}

}  // namespace lightbatch::pipeline
