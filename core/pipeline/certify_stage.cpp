#include "core/pipeline/certify_stage.h"

#include <algorithm>
#include <cmath>

#include "core/accuracy/path_tracer.h"
#include "core/base/random.h"
#include "core/lightmap/texel_points.h"

namespace lightbatch::pipeline {
namespace {

/// Texels drawn for judging; the certificate uses a prefix.
constexpr std::size_t kProbes = 8192;
constexpr double kFewestPaths = 2e5;
/// But no more rays than these: between the whitest walls a path has a thousand.
constexpr double kFewestRays = 2e7;
constexpr double kMostPaths = 8e6;
/// Paths that an ordinary room takes until noise no longer hides an error of 1 % (they go as error
/// to minus 2), and limits of what a certificate may take of them however small the bake.
constexpr double kPathsAtOnePercent = 2.2e6;
constexpr double kFewestOwn = 4e5, kMostOwn = 2.2e6;
/// Rays of these paths at most: a second or two.
constexpr double kMostOwnRays = 8e6;

/// A certificate's paths, over its budget, while a map seems to miss its target and may yet keep
/// it.
constexpr double kBudgetsInDoubt = 4;

/// Share of the probes that go to surface by its area; the others go by baked light, so that what
/// is lit is judged where it is a small part of all surfaces.
constexpr double kByArea = 0.5;

/// Texels in random order: one in each of kProbes equal parts of a mixture of area and light, then
/// shuffled. The probes read `places` when they are judged.
std::vector<accuracy::Probe> draw_probes(const LightmapPlaces& places, const LightBake& light,
                                         std::uint64_t seed,
                                         const std::vector<std::uint8_t>* among = nullptr) {
  const auto& texels = places.texels.texels;
  const auto area_of = [&](std::size_t t) {
    return among == nullptr || (*among)[t] != 0 ? places.texels.surface_of(texels[t]) : 0.0;
  };
  const auto lux_of = [&](std::size_t t) {
    return std::max(0.0, static_cast<double>(light.baked.irradiance[t].sum()));
  };
  double area = 0, flux = 0;
  for (std::size_t t = 0; t < texels.size(); ++t) {
    area += area_of(t);
    flux += area_of(t) * lux_of(t);
  }
  std::vector<accuracy::Probe> probes;
  if (!(area > 0)) return probes;
  // Density against that of area alone; weights are at most 1 / kByArea.
  const auto density = [&](std::size_t t) {
    return flux > 0 ? kByArea + (1 - kByArea) * lux_of(t) * area / flux : 1.0;
  };
  std::vector<double> up_to(texels.size());
  double total = 0;
  for (std::size_t t = 0; t < texels.size(); ++t) {
    total += area_of(t) * density(t);
    up_to[t] = total;
  }
  Random random(item_seed(seed, 0, 31));
  for (std::size_t k = 0; k < kProbes; ++k) {
    const double at = total * (static_cast<double>(k) + random.next_double()) / kProbes;
    const auto t = std::min(
        texels.size() - 1,
        static_cast<std::size_t>(std::upper_bound(up_to.begin(), up_to.end(), at) - up_to.begin()));
    accuracy::Probe probe;
    probe.value = light.baked.irradiance[t];
    probe.weight = 1 / density(t);
    probe.points = points_of(places, texels[t]);
    probes.push_back(std::move(probe));
  }
  for (std::size_t k = probes.size(); k > 1; --k) {
    std::swap(probes[k - 1], probes[random.below(k)]);
  }
  return probes;
}

double bake_rays(const LightBake& light) {
  return static_cast<double>(light.baked.counts.rays.cast() + light.radiosity.rays.cast());
}

/// What is switched off is not in the truth either.
accuracy::PathTracer tracer_of(const JobOptions& options, const Prepared& p) {
  using plan::Effect;
  accuracy::TracedLight traced;
  traced.punctual_direct = options.lights == LightsPolicy::kRemove;
  traced.lights.points = p.effects.on(Effect::kPointLights);
  traced.lights.spots = p.effects.on(Effect::kSpotLights);
  traced.lights.suns = p.effects.on(Effect::kDirectionalLights);
  traced.lights.emitters = p.effects.on(Effect::kEmitters);
  traced.interreflection = p.effects.on(Effect::kInterreflection);
  traced.shadows = p.effects.on(Effect::kShadows);
  return {*p.caster, *p.optics, p.whole_sky, traced};
}

/// Bounces that a path takes on average, 1 / (1 - rho) with the area mean of rho.
double mean_bounces(const Prepared& p) {
  double reflected = 0, area = 0;
  for (std::uint32_t i = 0; i < p.scene->triangles.size(); ++i) {
    const double a = p.scene->area(i);
    reflected += a * static_cast<double>(p.optics->reflectance(i, 1.0f / 3, 1.0f / 3).max());
    area += a;
  }
  return area > 0 ? 1.0 / std::max(1e-3, 1.0 - reflected / area) : 1.0;
}

/// Paths of a quarter of the price of the bake, within limits.
double quarter_of(double bake_rays, double rays_a_path) {
  const double fewest = std::min(kFewestPaths, kFewestRays / rays_a_path);
  return std::clamp(0.25 * bake_rays / rays_a_path, fewest, kMostPaths);
}

}  // namespace

accuracy::PointSource points_of(const LightmapPlaces& places, const atlas::Texel& texel) {
  return [&layout = places.layout, points = lightmap::texel_points(places.texels, texel)](
             float which, Vec2f within) {
    const auto i = static_cast<std::uint32_t>(which * static_cast<float>(points.count));
    const auto& point = points.point[std::min(points.count - 1, i)];
    const auto q = lightmap::surface_point(layout, point, within);
    return accuracy::SurfacePoint{q.triangle, q.u, q.v, point.back};
  };
}

Result<accuracy::Certificate> certify(const JobOptions& options, const Prepared& p,
                                      const LightmapPlaces& places, const LightBake& light,
                                      StageClock& clock, const Progress& progress) {
  clock.start("certify");
  progress.report("certify", 0);
  const accuracy::PathTracer tracer = tracer_of(options, p);
  const auto probes = draw_probes(places, light, options.seed);
  accuracy::CertificateOptions certificate_options;
  certificate_options.target = p.target_error;
  certificate_options.seed = item_seed(options.seed, 1, 32);
  certificate_options.max_paths = certificate_budget(p, bake_rays(light), p.target_error);
  // A map that is asked for by its price is paid for by it.
  certificate_options.budgets_in_doubt = options.time_budget > 0 ? 1 : kBudgetsInDoubt;
  certificate_options.map_mean = mean_of_map(places, light);
  auto certificate = accuracy::certify(tracer, probes, certificate_options, progress);
  clock.stop();
  return certificate;
}

Result<BorderChecks> check_borders(const JobOptions& options, const Prepared& p,
                                   const LightmapPlaces& places, const LightBake& light,
                                   const std::vector<lightmap::PageImage>& pages, StageClock& clock,
                                   const Progress& progress) {
  clock.start("borders");
  progress.report("borders", 0);
  BorderChecks checks;
  accuracy::LeakOptions leak_options;
  leak_options.mean_irradiance = mean_of_map(places, light);
  leak_options.bright = p.target_error;
  leak_options.seed = item_seed(options.seed, 4, 34);
  checks.seams = accuracy::measure_seams(*p.scene, *p.caster, places.layout, places.texels, pages,
                                         leak_options.mean_irradiance);
  const accuracy::PathTracer tracer = tracer_of(options, p);
  LB_ASSIGN_OR_RETURN(
      checks.leaks, accuracy::find_leaks(tracer, *p.caster, *p.scene, places.layout, places.texels,
                                         pages, leak_options, progress));
  clock.stop();
  return checks;
}

std::uint64_t path_budget(const Prepared& p, double bake_rays) {
  return static_cast<std::uint64_t>(quarter_of(bake_rays, 1.0 + mean_bounces(p)));
}

std::uint64_t certificate_budget(const Prepared& p, double bake_rays, double target) {
  const double rays_a_path = 1.0 + mean_bounces(p);
  const double own =
      std::clamp(kPathsAtOnePercent * std::pow(0.01 / target, 2), kFewestOwn, kMostOwn);
  return static_cast<std::uint64_t>(
      std::max(quarter_of(bake_rays, rays_a_path), std::min(own, kMostOwnRays / rays_a_path)));
}

Result<PilotTruth> judge_pilot(const JobOptions& options, const Prepared& p,
                               const LightmapPlaces& places, const LightBake& light,
                               const std::vector<std::uint8_t>& selected, std::uint64_t paths,
                               const Progress& progress) {
  accuracy::CertificateOptions all;
  all.target = 1e-6;  // never reached: the whole budget is spent
  all.max_paths = paths;
  all.seed = item_seed(options.seed, 2, 33);
  const accuracy::PathTracer tracer = tracer_of(options, p);
  const auto probes = draw_probes(places, light, item_seed(options.seed, 3, 33), &selected);
  const StageClock clock;
  LB_ASSIGN_OR_RETURN(const accuracy::Certificate run,
                      accuracy::certify(tracer, probes, all, progress));
  return PilotTruth{run.low,
                    run.paths > 0 ? clock.seconds() / static_cast<double>(run.paths) : 0.0};
}

nlohmann::json report_accuracy(const accuracy::Certificate& c, double target) {
  const bool passed = c.relrmse <= target;
  return {{"target", target},
          {"certified", c.relrmse},
          {"low", c.low},
          {"high", c.high},
          {"p95", c.p95},
          {"bias", c.bias},
          {"bias_low", c.bias_low},
          {"bias_high", c.bias_high},
          {"probes", c.probes},
          {"paths", c.paths},
          {"mean_irradiance_lux", c.mean_irradiance},
          {"passed", passed}};
}

nlohmann::json report_borders(const scene::Scene& scene, const BorderChecks& checks) {
  const auto seam = [](const char* surface, const accuracy::StepFigures& f) -> nlohmann::json {
    return {{"surface", surface}, {"metres", f.metres}, {"points", f.points},
            {"rms", f.rms},       {"p95", f.p95},       {"largest", f.largest}};
  };
  const accuracy::Leaks& l = checks.leaks;
  nlohmann::json leaks = {{"points", l.points},
                          {"leaks", l.leaks},
                          {"area_share", l.area_share},
                          {"largest", l.largest},
                          {"hidden", l.hidden}};
  if (l.triangle != scene::kNone)
    leaks["brightest_on"] = scene.objects[scene.triangles[l.triangle].object].name;
  return {{"seams", {seam("flat", checks.seams.flat), seam("folded", checks.seams.folded)}},
          {"divided_metres", checks.seams.divided_metres},
          {"leaks", leaks}};
}

}  // namespace lightbatch::pipeline
