#include "core/pipeline/first_stage.h"

#include <algorithm>
#include <iterator>

#include "core/radiosity/linked_solver.h"

namespace lightbatch::pipeline {
namespace {

using plan::Effect;

/// Memory that light by group may take.
constexpr std::uint64_t kMostGroupedBytes = std::uint64_t{1} << 30;
/// Values of a texel or an element by group that are there at one time.
constexpr std::uint64_t kCopies = 4;

}  // namespace

FirstStage::FirstStage(const JobOptions& job, const Prepared& p,
                       const accuracy::BakeSettings& bake_settings)
    : settings(bake_settings),
      sources(*p.scene, *p.optics,
              {p.effects.on(Effect::kPointLights), p.effects.on(Effect::kSpotLights),
               p.effects.on(Effect::kDirectionalLights), p.effects.on(Effect::kEmitters),
               job.lights == LightsPolicy::kRemove},
              p.suns),
      direct(*p.optics, *p.caster, sources, p.effects.on(Effect::kShadows)),
      elements(*p.scene, p.tree, *p.optics, settings.elements, p.caster.get()),
      lookup(*p.scene, *p.caster, elements, direct.lift()),
      options(settings.solver) {
  options.interreflection = p.effects.on(Effect::kInterreflection);
}

Status FirstStage::solve(const Prepared& p, SolverMode mode, std::size_t texels,
                         const Progress& progress) {
  linked = mode == SolverMode::kLinked;
  std::size_t apart = 0;
  if (texels > 0) {
    groups = sources.groups();
    groups.push_back({radiosity::LightGroup::Kind::kSky, 0, "sky", {1, 1, 1}});
    const bool several = groups.size() - (p.whole_sky.is_black() ? 1 : 0) > 1;
    const std::uint64_t items = std::max<std::uint64_t>(texels, elements.count());
    if (several && (linked || kCopies * groups.size() * items * sizeof(Rgb) > kMostGroupedBytes)) {
      groups.clear();
    } else if (several) {
      apart = groups.size();
    }
  }
  const radiosity::SolverInput input{*p.scene, p.tree, *p.optics, *p.caster, elements,
                                     direct,   p.sky,  lookup,    apart};
  LB_ASSIGN_OR_RETURN(solution, linked ? radiosity::solve_linked(input, options, progress)
                                       : radiosity::solve_stored_rays(input, options, progress));
  return {};
}

double FirstStage::irradiance_of(std::uint32_t triangle, bool back) const {
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

}  // namespace lightbatch::pipeline
