#include "core/pipeline/light_stage.h"

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

/// Mean irradiance over the surfaces that have texels, all channels.
double mean_over_texels(const Prepared& p, const LightmapPlaces& places,
                        const radiosity::Elements& elements, const radiosity::Solution& solution) {
  double sum = 0, area = 0;
  for (std::uint32_t i = 0; i < p.scene->triangles.size(); ++i) {
    if (places.layout.chart_of[i] == scene::kNone) continue;
    // Cells of large triangles: a fixed spread of points stands for them.
    constexpr float kSpread[][2] = {{0.333f, 0.333f}, {0.1f, 0.1f},  {0.8f, 0.1f}, {0.1f, 0.8f},
                                    {0.45f, 0.45f},   {0.1f, 0.45f}, {0.45f, 0.1f}};
    double mean = 0;
    for (const auto& uv : kSpread) {
      const radiosity::ElementId e = elements.at(i, uv[0], uv[1], false);
      mean += static_cast<double>(solution.irradiance[e].sum()) / (3.0 * std::size(kSpread));
    }
    const double a = triangle_area(*p.scene, i);
    sum += mean * a;
    area += a;
  }
  return area > 0 ? sum / area : 0;
}

}  // namespace

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
  clock.stop();
  return places;
}

accuracy::SceneMeasure measure_for_settings(const Prepared& p, const LightmapPlaces& places) {
  return {area_of(*p.scene, [&](std::uint32_t i) { return p.optics->double_sided(i) ? 2.0 : 1.0; }),
          places.texels.texels.size()};
}

Result<LightBake> bake_light(const JobOptions& options, const Prepared& p,
                             const LightmapPlaces& places, const accuracy::BakeSettings& settings,
                             StageClock& clock, const Progress& progress,
                             const std::vector<std::uint8_t>* selected) {
  clock.start("radiosity");
  progress.report("radiosity", 0);
  LightBake bake;
  bake.settings = settings;
  const radiosity::LightSources sources(
      *p.scene, *p.optics,
      {p.effects.on(Effect::kPointLights), p.effects.on(Effect::kSpotLights),
       p.effects.on(Effect::kDirectionalLights), p.effects.on(Effect::kEmitters)});
  const radiosity::DirectLight direct(*p.optics, *p.caster, sources,
                                      p.effects.on(Effect::kShadows));
  const radiosity::Elements elements(*p.scene, p.tree, *p.optics, settings.elements);
  bake.element_edge = elements.edge();
  const radiosity::ElementLookup lookup(*p.scene, *p.caster, elements, direct.lift());
  radiosity::SolverOptions solver = settings.solver;
  solver.interreflection = p.effects.on(Effect::kInterreflection);
  const radiosity::SolverInput solver_input{*p.scene, p.tree, *p.optics, *p.caster,
                                            elements, direct, p.sky,     lookup};
  const bool linked = options.solver == SolverMode::kLinked;
  LB_ASSIGN_OR_RETURN(const radiosity::Solution solution,
                      linked ? radiosity::solve_linked(solver_input, solver, progress)
                             : radiosity::solve_stored_rays(solver_input, solver, progress));
  bake.mode = linked ? "linked" : "stored-ray";
  bake.radiosity = solution.statistics;
  bake.mean_irradiance = mean_over_texels(p, places, elements, solution);

  clock.start("gather");
  lightmap::BakeInput input{*p.scene, *p.optics, *p.caster, p.sky,         direct,
                            elements, lookup,    solution,  places.layout, places.texels};
  input.indirect = solver.interreflection || !p.sky.is_black();
  input.direct_lights = !sources.punctual().empty() || !sources.emitters().empty();
  input.mean_irradiance = bake.mean_irradiance;
  input.seed = options.seed;
  input.selected = selected;
  LB_ASSIGN_OR_RETURN(bake.baked, lightmap::bake_texels(input, settings.gather, progress));
  clock.stop();
  return bake;
}

}  // namespace lightbatch::pipeline
