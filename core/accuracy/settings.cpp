#include "core/accuracy/settings.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lightbatch::accuracy {
namespace {

/// Rungs of the ladder, coarse first.
struct Rung {
  double error;
  double elements;  // on the scene's surface, if it were flat
  double stored_rays;
  double direct_samples;
  double gather_rays;
  double block;
  double tolerance;
  double reach;
  double pilot_rays;
  double direct_error;
};

constexpr std::array<Rung, 6> kLadder{{
    {0.10, 2'000, 12, 6, 32, 8, 0.080, 1.00, 4, 0.15},
    {0.05, 5'000, 16, 8, 64, 8, 0.045, 0.70, 4, 0.075},
    {0.02, 15'000, 24, 8, 192, 8, 0.025, 0.50, 4, 0.03},
    {0.01, 40'000, 32, 8, 448, 4, 0.014, 0.40, 8, 0.015},
    {0.005, 120'000, 48, 12, 1280, 4, 0.008, 0.30, 8, 0.0075},
    {0.002, 400'000, 64, 16, 4096, 4, 0.004, 0.25, 16, 0.003},
}};

}  // namespace

BakeSettings settings_for(double target_error, const SceneMeasure& scene, std::uint64_t seed,
                          double effort) {
  const double error = std::clamp(target_error, kLadder.back().error, kLadder.front().error);
  std::size_t i = 0;
  while (i + 2 < kLadder.size() && error < kLadder[i + 1].error) ++i;
  const Rung& a = kLadder[i];
  const Rung& b = kLadder[i + 1];
  const double t = std::log(a.error / error) / std::log(a.error / b.error);
  const auto mix = [t](double from, double to) { return from * std::pow(to / from, t); };
  const auto whole = [](double v) { return static_cast<int>(std::lround(v)); };

  BakeSettings settings;
  settings.target_error = target_error;
  const double elements = std::max(64.0, mix(a.elements, b.elements) * effort);
  settings.elements.edge =
      scene.reflecting_area > 0 ? std::sqrt(scene.reflecting_area / elements) : 1.0;
  settings.solver.rays = std::max(4, whole(mix(a.stored_rays, b.stored_rays) * std::sqrt(effort)));
  settings.solver.direct_samples = std::max(4, whole(mix(a.direct_samples, b.direct_samples)));
  settings.solver.tolerance = std::min(1e-4, 0.01 * error);
  settings.solver.seed = seed;
  settings.gather.rays = std::max(16, whole(mix(a.gather_rays, b.gather_rays) * effort));
  settings.gather.block = t < 0.5 ? whole(a.block) : whole(b.block);
  settings.gather.tolerance = mix(a.tolerance, b.tolerance) / std::sqrt(effort);
  settings.gather.reach = mix(a.reach, b.reach);
  settings.gather.pilot_rays = whole(mix(a.pilot_rays, b.pilot_rays));
  settings.gather.direct_error = mix(a.direct_error, b.direct_error) / std::sqrt(effort);
  return settings;
}

}  // namespace lightbatch::accuracy
