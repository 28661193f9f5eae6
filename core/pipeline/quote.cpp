#include "core/pipeline/quote.h"

#include <algorithm>
#include <cmath>

#include "core/pipeline/certify_stage.h"
#include "core/pipeline/pilot.h"

namespace lightbatch::pipeline {
namespace {

/// Targets that get a pilot of their own; the others are priced from the nearest finer pilot, or
/// the finest.
constexpr double kPiloted[] = {0.10, 0.03};
/// Writing, batches and pages, per triangle and per texel of the scene (seconds): measured on the
/// shared scenes, a small part of a bake.
constexpr double kWritePerTriangle = 2.5e-6;
constexpr double kWritePerTexel = 6e-7;
/// A certificate stops between half of its budget and the whole.
constexpr double kSpentPaths = 0.7;

}  // namespace

Result<std::vector<Price>> quote(const JobOptions& options, const Prepared& p,
                                 const LightmapPlaces& places, StageClock& clock,
                                 const Progress& progress) {
  const double before = clock.seconds();
  const double after = kWritePerTriangle * static_cast<double>(p.scene->triangles.size()) +
                       kWritePerTexel * static_cast<double>(places.texels.texels.size());
  clock.start("pilot");
  std::vector<Tuned> tuned;
  for (const double target : kPiloted) {
    LB_ASSIGN_OR_RETURN(Tuned t, tune(options, p, places, target, progress));
    tuned.push_back(std::move(t));
  }
  clock.stop();
  std::vector<Price> prices;
  for (const double target : kQuotedErrors) {
    const bool coarse = target >= kPiloted[0];
    const Pilot& pilot = tuned[coarse ? 0 : 1].pilot;
    const accuracy::Rungs rungs = rungs_for(pilot, target);
    const double paths = kSpentPaths * static_cast<double>(path_budget(p, rays_at(pilot, rungs)));
    prices.push_back({target, error_at(pilot, rungs),
                      before + seconds_at(pilot, rungs) + paths * pilot.seconds_a_path + after});
  }
  return prices;
}

double error_for_time(const std::vector<Price>& prices, double seconds) {
  double best = prices.front().target;
  for (std::size_t i = 0; i < prices.size(); ++i) {
    if (prices[i].seconds <= seconds) best = prices[i].target;
    if (i + 1 < prices.size() && prices[i].seconds <= seconds && seconds < prices[i + 1].seconds) {
      const double t = std::log(seconds / prices[i].seconds) /
                       std::log(prices[i + 1].seconds / prices[i].seconds);
      best = prices[i].target * std::pow(prices[i + 1].target / prices[i].target, t);
    }
  }
  return best;
}

}  // namespace lightbatch::pipeline
