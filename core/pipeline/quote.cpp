#include "core/pipeline/quote.h"

#include <algorithm>
#include <cmath>

#include "core/accuracy/path_tracer.h"
#include "core/pipeline/certify_stage.h"

namespace lightbatch::pipeline {
namespace {

/// Texels that a pilot bakes, about.
constexpr double kPilotTexels = 3000;
/// The finest settings a pilot runs; finer prices follow the trend of the two finest runs.
constexpr double kFinestPilot = 0.01;
/// Writing, batches and pages, per triangle and per texel of the scene (seconds): measured on the
/// shared scenes, a small part of a bake.
constexpr double kWritePerTriangle = 2.5e-6;
constexpr double kWritePerTexel = 6e-7;

struct Pilot {
  double target = 0;
  double seconds = 0;
  std::vector<Rgb> values;  // of the selected texels
};

double share_selected(const std::vector<std::uint8_t>& selected) {
  const auto count = std::count(selected.begin(), selected.end(), 1);
  return selected.empty()
             ? 1.0
             : std::max(1e-6, static_cast<double>(count) / static_cast<double>(selected.size()));
}

double difference(const std::vector<Rgb>& values, const std::vector<Rgb>& truth) {
  double squares = 0, sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Rgbd d = to_double(values[i]) - to_double(truth[i]);
    squares += d.r * d.r + d.g * d.g + d.b * d.b;
    sum += to_double(truth[i]).sum();
  }
  const double n = 3.0 * static_cast<double>(values.size());
  return sum > 0 ? std::sqrt(squares / n) / (sum / n) : 0;
}

}  // namespace

Result<std::vector<Price>> quote(const JobOptions& options, const Prepared& p,
                                 const LightmapPlaces& places, StageClock& clock,
                                 const Progress& progress) {
  const double before = clock.seconds();
  const double after = kWritePerTriangle * static_cast<double>(p.scene->triangles.size()) +
                       kWritePerTexel * static_cast<double>(places.texels.texels.size());
  const auto measure = measure_for_settings(p, places);
  std::vector<Pilot> pilots;
  clock.start("pilot");
  for (const double target : kQuotedErrors) {
    if (target < kFinestPilot) continue;
    progress.report("pilot at " + std::to_string(std::lround(100 * target)) + "%", 0);
    const auto settings = accuracy::settings_for(target, measure, options.seed);
    const auto divisor = static_cast<std::uint32_t>(
        std::max(1.0, static_cast<double>(places.texels.texels.size()) / kPilotTexels));
    // One selection for all pilots: blocks of the coarsest settings.
    const std::vector<std::uint8_t> selected =
        lightmap::select_texels(places.layout, places.texels, 8, divisor);
    StageClock own;
    LB_ASSIGN_OR_RETURN(LightBake bake,
                        bake_light(options, p, places, settings, own, progress, &selected));
    LB_ASSIGN_OR_RETURN(const double certify_seconds,
                        certify_price(options, p, places, bake, target, progress));
    Pilot pilot{target, 0, {}};
    const auto& stages = own.stages();
    pilot.seconds =
        stages[0].seconds + stages[1].seconds / share_selected(selected) + certify_seconds;
    for (std::size_t t = 0; t < selected.size(); ++t) {
      if (selected[t] != 0) pilot.values.push_back(bake.baked.irradiance[t]);
    }
    pilots.push_back(std::move(pilot));
  }
  std::vector<Price> prices;
  for (const Pilot& pilot : pilots) {
    const bool finest = &pilot == &pilots.back();
    prices.push_back({pilot.target, finest ? 0.0 : difference(pilot.values, pilots.back().values),
                      before + pilot.seconds + after});
  }
  const Pilot& last = pilots[pilots.size() - 1];
  const Pilot& one_before = pilots[pilots.size() - 2];
  const double slope = std::log(std::max(1.01, last.seconds / one_before.seconds)) /
                       std::log(one_before.target / last.target);
  for (const double target : kQuotedErrors) {
    if (target >= kFinestPilot) continue;
    prices.push_back(
        {target, 0, before + last.seconds * std::pow(last.target / target, slope) + after});
  }
  clock.stop();
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
