#include "core/pipeline/quote.h"

#include <algorithm>
#include <cmath>

#include "core/pipeline/certify_stage.h"

namespace lightbatch::pipeline {
namespace {

/// Targets that get a pilot of their own; between them, prices are interpolated from both, finer
/// ones are priced from the finest.
constexpr double kPiloted[] = {0.10, 0.03};
/// Writing, batches and pages, per triangle and per texel of the scene (seconds): measured on the
/// shared scenes, a small part of a bake.
constexpr double kWritePerTriangle = 2.5e-6;
constexpr double kWritePerTexel = 6e-7;
/// The report's pictures, as large for every scene (seconds).
constexpr double kPictures = 0.25;
/// A certificate stops between half of its budget and the whole.
constexpr double kSpentPaths = 0.7;

/// The pilot that a target is priced from.
const Tuned& pilot_for(const std::vector<Tuned>& pilots, double target) {
  return target >= kPiloted[0] || pilots.size() == 1 ? pilots.front() : pilots.back();
}

}  // namespace

Result<Quote> quote(const JobOptions& options, const Prepared& p, const LightmapPlaces& places,
                    StageClock& clock, const Progress& progress, double patience) {
  Quote quote;
  const double before = clock.seconds();
  const double after = kPictures +
                       kWritePerTriangle * static_cast<double>(p.scene->triangles.size()) +
                       kWritePerTexel * static_cast<double>(places.texels.texels.size());
  bool reuses = true;  // bakes take the first stage of their pilot
  clock.start("pilot");
  for (const double target : kPiloted) {
    if (!quote.pilots.empty() && clock.seconds() > patience) break;
    LB_ASSIGN_OR_RETURN(Tuned t, tune(options, p, places, target, progress, patience));
    reuses = reuses && t.first != nullptr;
    t.first = nullptr;
    quote.pilots.push_back(std::move(t));
  }
  clock.stop();
  if (quote.pilots.size() > 1) {
    Pilot& coarse = quote.pilots.front().pilot;
    Pilot& fine = quote.pilots.back().pilot;
    for (const auto part : {&Pilot::direct, &Pilot::indirect}) {
      (fine.*part).growth = accuracy::growth_between(coarse.*part, fine.*part);
      (coarse.*part).growth = (fine.*part).growth;
    }
  }
  const auto price_from = [&](const Tuned& tuned, double target) {
    const Pilot& pilot = tuned.pilot;
    const accuracy::Rungs rungs = rungs_for(pilot, target);
    const double paths =
        kSpentPaths * static_cast<double>(certificate_budget(p, rays_at(pilot, rungs), target));
    const double rest = seconds_at(pilot, rungs) + paths * pilot.seconds_a_path + after;
    // A pilot starts at its target's own rungs.
    const double own =
        tuned.seconds * std::pow(tuned.rungs.target / target, pilot.indirect.growth.cost);
    const double spared = reuses ? stage_seconds_at(pilot, rungs) : 0;
    return Price{target, error_at(pilot, rungs), before + own + rest - spared, rest};
  };
  for (const double target : kQuotedErrors) {
    Price price = price_from(pilot_for(quote.pilots, target), target);
    if (quote.pilots.size() > 1 && target < kPiloted[0] && target > kPiloted[1]) {
      const Price coarse = price_from(quote.pilots.front(), target);
      const double t = std::log(target / kPiloted[1]) / std::log(kPiloted[0] / kPiloted[1]);
      const auto mix = [&](double& fine, double other) {
        if (fine > 0 && other > 0) fine *= std::pow(other / fine, t);
      };
      mix(price.error, coarse.error);
      mix(price.seconds, coarse.seconds);
      mix(price.rest, coarse.rest);
    }
    quote.prices.push_back(price);
  }
  for (const double target : kCoarserErrors) {
    quote.coarser.push_back(price_from(quote.pilots.front(), target));
  }
  return quote;
}

double error_for_time(const Quote& quote, double seconds) {
  std::vector<Price> prices = quote.coarser;
  prices.insert(prices.end(), quote.prices.begin(), quote.prices.end());
  double best = prices.front().target;
  for (std::size_t i = 0; i < prices.size(); ++i) {
    const Price& price = prices[i];
    if (price.rest <= seconds) best = price.target;
    if (i + 1 < prices.size() && price.rest <= seconds && seconds < prices[i + 1].rest) {
      const double t = std::log(seconds / price.rest) / std::log(prices[i + 1].rest / price.rest);
      best = price.target * std::pow(prices[i + 1].target / price.target, t);
    }
  }
  return best;
}

Tuned tuned_from(const Quote& quote, double target) {
  Tuned tuned = pilot_for(quote.pilots, target);
  tuned.rungs = rungs_for(tuned.pilot, target);
  return tuned;
}

}  // namespace lightbatch::pipeline
