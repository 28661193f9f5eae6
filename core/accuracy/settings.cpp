#include "core/accuracy/settings.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lightbatch::accuracy {
namespace {

/// One rung of the ladder.
struct Rung {
  double error;
  double elements;  // on the scene's surface, if it were flat
  double stored_rays;
  double direct_samples;
  double gather_rays;
  double pilot_rays;
};

constexpr std::array<Rung, 8> kLadder{{
    {kCoarsestRung, 800, 16, 4, 8, 4},
    {0.10, 5'000, 28, 8, 32, 4},
    {0.05, 12'000, 40, 8, 80, 4},
    {0.02, 22'000, 72, 8, 240, 4},
    {0.01, 40'000, 80, 12, 480, 8},
    {0.005, 70'000, 88, 12, 1'000, 8},
    {0.002, 180'000, 100, 16, 3'400, 16},
    {kFinestRung, 600'000, 128, 16, 20'000, 16},
}};

/// Errors of the parts that are bounded by settings of their own, against the target.
constexpr double kEdgeShare = 1.5;     // of visibility in a texel of a shadow's edge
constexpr double kSharingShare = 1.0;  // of a block's middle against its corners
/// Virtual lights and rays to them, against the rays of a texel.
constexpr int kRaysOverVirtualRays = 3;
constexpr int kVirtualLightsPerRay = 32;
constexpr int kFewestVirtual = 1024, kMostVirtual = 16384;
/// Texel sizes, at 5 %: what is nearer is not left to the texel there.
constexpr double kLinked = 0.3;
/// Target from which on dim places count by their own light, and most so at half of it.
constexpr double kDimCounts = 0.02, kMostDim = 0.6;
constexpr double kFineSharing = 0.015;  // below: blocks start at 4 texels

/// Position on the ladder.
struct Place {
  const Rung& a;
  const Rung& b;
  double t;
  explicit Place(double error) : Place(find(error), error) {}
  double mix(double Rung::*field) const { return a.*field * std::pow(b.*field / a.*field, t); }
  int whole(double Rung::*field) const { return static_cast<int>(std::lround(mix(field))); }

 private:
  Place(std::size_t i, double error)
      : a(kLadder[i]),
        b(kLadder[i + 1]),
        t(std::clamp(std::log(a.error / error) / std::log(a.error / b.error), 0.0, 1.0)) {}
  static std::size_t find(double error) {
    std::size_t i = 0;
    while (i + 2 < kLadder.size() && error < kLadder[i + 1].error) ++i;
    return i;
  }
};

}  // namespace

double dim_exponent(double target) {
  return kMostDim * std::clamp(std::log2(kDimCounts / target), 0.0, 1.0);
}

BakeSettings settings_for(const Rungs& rungs, const SceneMeasure& scene, std::uint64_t seed) {
  const Place direct(rungs.direct), first(rungs.first), gather(rungs.gather);
  BakeSettings settings;
  settings.target_error = rungs.target;
  settings.elements.edge = scene.reflecting_area > 0
                               ? std::sqrt(scene.reflecting_area / first.mix(&Rung::elements))
                               : 1.0;
  settings.solver.rays = first.whole(&Rung::stored_rays);
  settings.solver.direct_samples = first.whole(&Rung::direct_samples);
  settings.solver.tolerance = std::min(1e-4, 0.01 * rungs.target);
  settings.solver.seed = seed;
  settings.gather.rays = gather.whole(&Rung::gather_rays);
  settings.gather.block = rungs.target < kFineSharing ? 4 : 8;
  settings.gather.tolerance = kSharingShare * rungs.target;
  settings.gather.reach = std::clamp(3.2 * std::sqrt(rungs.target), 0.25, 1.0);
  settings.gather.virtual_rays = std::max(4, settings.gather.rays / kRaysOverVirtualRays);
  settings.gather.virtual_lights =
      std::clamp(kVirtualLightsPerRay * settings.gather.rays, kFewestVirtual, kMostVirtual);
  settings.gather.linked = std::min(1.0, kLinked * std::pow(0.05 / rungs.gather, 0.75));
  settings.gather.dim = dim_exponent(rungs.target);
  settings.gather.pilot_rays = direct.whole(&Rung::pilot_rays);
  settings.gather.direct_error = kEdgeShare * std::max(kFinestRung, rungs.direct);
  return settings;
}

}  // namespace lightbatch::accuracy
