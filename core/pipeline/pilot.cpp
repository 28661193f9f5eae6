#include "core/pipeline/pilot.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/pipeline/certify_stage.h"

namespace lightbatch::pipeline {
namespace {

using accuracy::Rungs;

/// Texels of a pilot: a share of the map, within limits that keep its figure steady and its price
/// small.
constexpr double kShareOfTexels = 0.02;
constexpr double kFewestTexels = 2500;
constexpr double kMostTexels = 10000;
/// Edge of a patch of pilot texels: wide enough for neighbours to be averaged as in the whole map.
constexpr int kPatch = 16;
/// The error aimed at, against the target: the pilot's own error and the certificate's must fit
/// between.
constexpr double kAim = 0.75;
/// Indirect light is read at a rung of this many targets at most, direct light at the target's own:
/// edges of shadows are few, so that a map's error hardly knows of them, but they are looked at. No
/// part is read at a finer rung than the share: what has not fallen by then does not fall with
/// rays.
constexpr double kLeastCare = 4;
constexpr double kMostCare = 1.0 / 12;
/// A choice within this factor of the pilot's rung is believed.
constexpr double kNear = 2.0;
/// Of the certificate's paths, for judging a pilot.
constexpr double kShareOfPaths = 0.25;
/// Errors are believed to be at most this many times what the two runs differ by.
constexpr double kMostExcess = 1.6;
/// A first stage serves rungs down to this part of its own.
constexpr double kCoarseEnough = 1.4;
/// Rungs of the two runs of a pilot, the earlier one's over the later's; an earlier pilot's run at
/// rungs within the limits serves as the earlier one.
constexpr double kApart = 2.0;
constexpr double kLeastApart = 0.5, kMostApart = 4.0;
/// Of the target: where indirect light is first read. Most scenes are smooth.
constexpr double kFirstLook = 1.6;

/// Light of the selected texels by parts.
struct Parts {
  std::vector<Rgb> direct, indirect;
};

Parts parts_of(const LightBake& bake, const std::vector<std::uint8_t>& selected) {
  Parts parts;
  for (std::size_t t = 0; t < selected.size(); ++t) {
    if (selected[t] == 0) continue;
    parts.direct.push_back(bake.baked.direct[t]);
    parts.indirect.push_back(bake.baked.irradiance[t] - bake.baked.direct[t]);
  }
  return parts;
}

std::vector<double> areas_of(const LightmapPlaces& places,
                             const std::vector<std::uint8_t>& selected) {
  std::vector<double> areas;
  for (std::size_t t = 0; t < selected.size(); ++t) {
    if (selected[t] == 0) continue;
    areas.push_back(places.texels.surface_of(places.texels.texels[t]));
  }
  return areas;
}

/// Root of the mean square by area, mean over channels, of a - b.
double difference(const std::vector<Rgb>& a, const std::vector<Rgb>& b,
                  const std::vector<double>& areas) {
  double squares = 0, area = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Rgbd d = to_double(a[i]) - to_double(b[i]);
    squares += areas[i] * (d.r * d.r + d.g * d.g + d.b * d.b) / 3;
    area += areas[i];
  }
  return area > 0 ? std::sqrt(squares / area) : 0;
}

double mean_of(const Parts& parts, const std::vector<double>& areas) {
  double sum = 0, area = 0;
  for (std::size_t i = 0; i < areas.size(); ++i) {
    sum += areas[i] * static_cast<double>((parts.direct[i] + parts.indirect[i]).sum()) / 3;
    area += areas[i];
  }
  return area > 0 ? sum / area : 0;
}

bool near(double a, double b) { return a < kNear * b && b < kNear * a; }

/// One run over the selected texels.
struct Run {
  Rungs at;
  Parts parts;
  bool is_there = false;

  bool serves(const Rungs& later) const {
    const auto within = [](double apart) { return apart >= kLeastApart && apart <= kMostApart; };
    return is_there && within(at.direct / later.direct) && within(at.indirect / later.indirect);
  }
};

/// last: the run before, in; the last one, out. number: of the runs so far.
Result<Pilot> run_pilot(const JobOptions& options, const Prepared& p, const LightmapPlaces& places,
                        const Rungs& at, Run& last, std::uint64_t& number,
                        const Progress& progress) {
  Pilot pilot;
  const auto measure = measure_for_settings(p, places);
  const auto texels = static_cast<double>(places.texels.texels.size());
  const double wanted = std::clamp(kShareOfTexels * texels, kFewestTexels, kMostTexels);
  const std::vector<std::uint8_t> selected =
      lightmap::select_texels(places.layout, places.texels, kPatch,
                              static_cast<std::uint32_t>(std::max(1.0, texels / wanted)));
  const std::vector<double> areas = areas_of(places, selected);
  if (areas.empty()) return pilot;
  const double whole = texels / static_cast<double>(areas.size());

  StageClock own;
  const auto run = [&](const Rungs& rungs, bool keep_first) {
    JobOptions other = options;
    other.seed = options.seed + number++;
    return bake_light(other, p, places, accuracy::settings_for(rungs, measure, other.seed), own,
                      progress, {&selected, keep_first, nullptr});
  };
  if (!last.serves(at)) {
    last.at = {at.target, kApart * at.direct, kApart * at.indirect};
    LB_ASSIGN_OR_RETURN(const LightBake rough, run(last.at, false));
    last.parts = parts_of(rough, selected);
  }
  LB_ASSIGN_OR_RETURN(const LightBake fine, run(at, true));
  pilot.first = fine.first;
  const Run rough = std::exchange(last, {at, parts_of(fine, selected), true});
  const Parts &a = rough.parts, &b = last.parts;
  const double mean = mean_of(b, areas);
  const double direct_rays = static_cast<double>(fine.baked.direct_rays) * whole;
  // Corners of the pilot's blocks belong to blocks beside it too, and texels that its own are
  // linked to are linked to others: all of them share, the pilot cannot.
  const auto& counts = fine.baked.counts;
  const auto gathered = static_cast<double>(counts.rays.cast() - fine.baked.direct_rays);
  const double shared =
      gathered > 0 ? (gathered - static_cast<double>(counts.border_rays)) / gathered : 1.0;
  const double gather_rays = gathered * whole * shared;
  const double solve_rays = static_cast<double>(fine.radiosity.rays.cast());
  // The difference has the error of both runs.
  const auto relative = [&](double d, double apart, const accuracy::Growth& growth) {
    return mean > 0 ? d / std::hypot(1, std::pow(apart, growth.error)) / mean : 0.0;
  };
  pilot.direct = {at.direct,
                  relative(difference(a.direct, b.direct, areas), rough.at.direct / at.direct,
                           accuracy::kDirectGrowth),
                  direct_rays, accuracy::kDirectGrowth};
  pilot.indirect = {at.indirect,
                    relative(difference(a.indirect, b.indirect, areas),
                             rough.at.indirect / at.indirect, accuracy::kIndirectGrowth),
                    gather_rays + solve_rays, accuracy::kIndirectGrowth};
  // Stages: the last two are radiosity and gather of the fine run.
  const auto& stages = own.stages();
  pilot.solve_seconds = stages[stages.size() - 2].seconds;
  pilot.direct_seconds = fine.baked.direct_seconds * whole;
  const double once = stages.back().seconds - fine.baked.direct_seconds - fine.baked.gather_seconds;
  pilot.gather_seconds = fine.baked.gather_seconds * whole * shared + once;
  const double rays = pilot.direct.cost + pilot.indirect.cost;
  LB_ASSIGN_OR_RETURN(const PilotTruth truth,
                      judge_pilot(options, p, places, fine, selected,
                                  static_cast<std::uint64_t>(
                                      kShareOfPaths * static_cast<double>(path_budget(p, rays))),
                                  progress));
  pilot.seconds_a_path = truth.seconds_a_path;
  // What both runs get wrong alike does not show in their difference. Path tracing few texels tells
  // little where light is uneven: of the lower end of its interval and, twice, what the runs tell,
  // the geometric mean counts.
  const double known = std::hypot(pilot.direct.error, pilot.indirect.error);
  if (known > 0) {
    pilot.excess = std::clamp(std::cbrt(truth.low / known), 1.0, kMostExcess);
    pilot.direct.error *= pilot.excess;
    pilot.indirect.error *= pilot.excess;
  }
  pilot.own_seconds = own.seconds();
  return pilot;
}

}  // namespace

Rungs rungs_for(const Pilot& pilot, double target) {
  Rungs rungs = accuracy::choose_rungs(target, kAim * target, pilot.direct, pilot.indirect);
  rungs.direct = std::clamp(rungs.direct, kMostCare * target, target);
  rungs.indirect = std::clamp(rungs.indirect, kMostCare * target, kLeastCare * target);
  return rungs;
}

Result<Tuned> tune(const JobOptions& options, const Prepared& p, const LightmapPlaces& places,
                   double target, const Progress& progress) {
  progress.report("pilot", 0);
  Tuned tuned;
  tuned.rungs = {target, target, std::min(kFirstLook * target, accuracy::kCoarsestRung)};
  Rungs at = tuned.rungs;
  Run last;
  std::uint64_t number = 0;
  for (int round = 0; round < 2; ++round) {
    at = tuned.rungs;
    LB_ASSIGN_OR_RETURN(tuned.pilot, run_pilot(options, p, places, at, last, number, progress));
    tuned.seconds += tuned.pilot.own_seconds;
    tuned.rungs = rungs_for(tuned.pilot, target);
    if (near(at.direct, tuned.rungs.direct) && near(at.indirect, tuned.rungs.indirect)) break;
  }
  // The error that the first stage leaves is a small part of the whole.
  if (at.indirect < kCoarseEnough * tuned.rungs.indirect) tuned.first = tuned.pilot.first;
  tuned.pilot.first = nullptr;
  return tuned;
}

double error_at(const Pilot& pilot, const Rungs& rungs) {
  return std::hypot(accuracy::error_at(pilot.direct, rungs.direct),
                    accuracy::error_at(pilot.indirect, rungs.indirect));
}

double rays_at(const Pilot& pilot, const Rungs& rungs) {
  return accuracy::cost_at(pilot.direct, rungs.direct) +
         accuracy::cost_at(pilot.indirect, rungs.indirect);
}

namespace {

/// What a part costs at another rung, over what it cost its pilot.
double times(const accuracy::PartPilot& part, double rung) {
  return part.cost > 0 ? accuracy::cost_at(part, rung) / part.cost : 1.0;
}

}  // namespace

double solve_seconds_at(const Pilot& pilot, const Rungs& rungs) {
  return pilot.solve_seconds * times(pilot.indirect, rungs.indirect);
}

double seconds_at(const Pilot& pilot, const Rungs& rungs) {
  return solve_seconds_at(pilot, rungs) +
         pilot.gather_seconds * times(pilot.indirect, rungs.indirect) +
         pilot.direct_seconds * times(pilot.direct, rungs.direct);
}

}  // namespace lightbatch::pipeline
