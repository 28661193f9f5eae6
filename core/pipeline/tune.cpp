#include "core/pipeline/tune.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/lightmap/dim.h"
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
/// Of the target: where the parts are first read. Most scenes are smooth.
constexpr double kFirstGather = 1.6;
constexpr double kFirstStage = 2;
/// A choice within this factor of the pilot's rung is believed; of the first stage, whose error is
/// the smaller part, within another.
constexpr double kNear = 2.0;
constexpr double kNearStage = 3.0;
/// A first stage serves rungs down to this part of its own.
constexpr double kFineEnough = 1.4;
/// Each goes no further than the one before can be compared with: coarse runs mislead.
constexpr int kMostRounds = 3;
/// Rungs of the two runs of a pilot, the earlier one's over the later's; an earlier pilot's run at
/// rungs within the limits serves as the earlier one.
constexpr double kApart = 2.0;
constexpr double kLeastApart = 0.5, kMostApart = 4.0;
/// Of the certificate's paths, for judging a pilot.
constexpr double kShareOfPaths = 0.25;
/// Errors are believed to be at most this many times what the two runs differ by.
constexpr double kMostExcess = 1.6;

using Light = std::vector<Rgb>;

/// Light of the selected texels by parts.
struct Run {
  Rungs at;
  Light direct, indirect;

  bool serves(const Rungs& later) const {
    const auto within = [](double apart) { return apart >= kLeastApart && apart <= kMostApart; };
    return !direct.empty() && within(at.direct / later.direct) && within(at.first / later.first) &&
           within(at.gather / later.gather);
  }
};

class Tuner {
 public:
  Tuner(const JobOptions& options, const Prepared& p, const LightmapPlaces& places,
        const Progress& progress)
      : options_(options),
        p_(p),
        places_(places),
        progress_(progress),
        measure_(measure_for_settings(p, places)) {
    const auto count = static_cast<double>(places.texels.texels.size());
    const double wanted = std::clamp(kShareOfTexels * count, kFewestTexels, kMostTexels);
    selected_ = lightmap::select_texels(places.layout, places.texels, kPatch,
                                        static_cast<std::uint32_t>(std::max(1.0, count / wanted)));
    for (std::size_t t = 0; t < selected_.size(); ++t) {
      if (selected_[t] == 0) continue;
      areas_.push_back(places.texels.surface_of(places.texels.texels[t]));
    }
    whole_ = count / std::max(1.0, static_cast<double>(areas_.size()));
  }

  Result<Tuned> run(double target, double patience) {
    Tuned tuned;
    tuned.rungs = {target, std::min(target, accuracy::kCoarsestRung),
                   std::min(kFirstStage * target, kCoarsestStage),
                   std::min(kFirstGather * target, accuracy::kCoarsestRung)};
    for (int round = 0; round < kMostRounds && !areas_.empty(); ++round) {
      Rungs at = tuned.rungs;
      if (round > 0) {
        at = {target, std::max(at.direct, last_.at.direct / kMostApart),
              std::max(at.first, last_.at.first / kMostApart),
              std::max(at.gather, last_.at.gather / kMostApart)};
      }
      LB_ASSIGN_OR_RETURN(tuned.pilot, pilot(at));
      tuned.rungs = rungs_for(tuned.pilot, target);
      if (near(at.direct, tuned.rungs.direct) && near(at.gather, tuned.rungs.gather) &&
          at.first < kNearStage * tuned.rungs.first) {
        break;
      }
      if (own_.seconds() > patience) break;
    }
    // What is there is used.
    if (stage_ != nullptr && last_.at.first < kFineEnough * tuned.rungs.first) {
      tuned.first = stage_;
      tuned.rungs.first = last_.at.first;
    }
    tuned.seconds = own_.seconds();
    return tuned;
  }

 private:
  static bool near(double a, double b) { return a < kNear * b && b < kNear * a; }

  Result<LightBake> bake(const Rungs& rungs, Run& run) {
    JobOptions other = options_;
    other.seed = options_.seed + runs_++;
    LB_ASSIGN_OR_RETURN(
        LightBake light,
        bake_light(other, p_, places_, accuracy::settings_for(rungs, measure_, other.seed), own_,
                   progress_, {&selected_, true, nullptr}));
    run = {rungs, {}, {}};
    for (std::size_t t = 0; t < selected_.size(); ++t) {
      if (selected_[t] == 0) continue;
      run.direct.push_back(light.baked.direct[t]);
      run.indirect.push_back(light.baked.irradiance[t] - light.baked.direct[t]);
    }
    return light;
  }

  Result<Pilot> pilot(const Rungs& at) {
    if (!last_.serves(at)) {
      const auto coarser = [](double rung) {
        return std::min(kApart * rung, accuracy::kCoarsestRung);
      };
      LB_RETURN_IF_ERROR(
          bake({at.target, coarser(at.direct), coarser(at.first), coarser(at.gather)}, last_)
              .status());
    }
    Run fine;
    LB_ASSIGN_OR_RETURN(const LightBake light, bake(at, fine));
    stage_ = light.first;
    const Run rough = std::exchange(last_, std::move(fine));
    Pilot pilot = price(light);
    const double mean = mean_light();
    weigh(at.target, mean);
    // The difference has the error of both runs.
    const auto relative = [&](double difference, double apart, const accuracy::Growth& growth) {
      return mean > 0 ? difference / std::hypot(1, std::pow(apart, growth.error)) / mean : 0.0;
    };
    pilot.direct.error = relative(difference(rough.direct, last_.direct),
                                  rough.at.direct / at.direct, pilot.direct.growth);
    pilot.indirect.error = relative(difference(rough.indirect, last_.indirect),
                                    rough.at.gather / at.gather, pilot.indirect.growth);
    LB_RETURN_IF_ERROR(judge(light, pilot));
    return pilot;
  }

  /// Rays and seconds of the whole map.
  Pilot price(const LightBake& light) const {
    const lightmap::BakedTexels& baked = light.baked;
    // Corners of the pilot's blocks belong to blocks beside it too, and texels that its own are
    // linked to are linked to others: all of them share, the pilot cannot.
    const auto direct_rays = static_cast<double>(baked.direct_rays);
    const double rays = static_cast<double>(baked.counts.rays.cast()) - direct_rays;
    const double shared = rays > 0 ? 1 - static_cast<double>(baked.counts.border_rays) / rays : 1.0;
    Pilot pilot;
    pilot.direct = {last_.at.direct, 0, direct_rays * whole_, accuracy::kDirectGrowth};
    pilot.indirect = {last_.at.gather, 0, rays * shared * whole_, accuracy::kIndirectGrowth};
    pilot.stage_rung = last_.at.first;
    pilot.stage_rays = static_cast<double>(light.radiosity.rays.cast());
    pilot.stage_seconds = light.stage_seconds;
    const double once = light.texel_seconds - baked.direct_seconds - baked.gather_seconds;
    pilot.directional_seconds = light.directional_seconds * whole_;
    pilot.direct_seconds = baked.direct_seconds * whole_;
    pilot.gather_seconds = baked.gather_seconds * whole_ * shared + once;
    return pilot;
  }

  /// What both runs get wrong alike does not show in their difference. Path tracing few texels
  /// tells little where light is uneven: of the lower end of its interval and, twice, what the runs
  /// tell, the geometric mean counts.
  Status judge(const LightBake& light, Pilot& pilot) const {
    const auto budget = static_cast<double>(path_budget(p_, rays_at(pilot, last_.at)));
    LB_ASSIGN_OR_RETURN(const PilotTruth truth,
                        judge_pilot(options_, p_, places_, light, selected_,
                                    static_cast<std::uint64_t>(kShareOfPaths * budget), progress_));
    pilot.seconds_a_path = truth.seconds_a_path;
    const double known = std::hypot(pilot.direct.error, pilot.indirect.error);
    if (!(known > 0)) return {};
    pilot.excess = std::clamp(std::cbrt(truth.low / known), 1.0, kMostExcess);
    pilot.direct.error *= pilot.excess;
    pilot.indirect.error *= pilot.excess;
    return {};
  }

  /// Mean by area over the selected texels.
  template <typename Value>
  double mean(Value value) const {
    double sum = 0, area = 0;
    for (std::size_t i = 0; i < areas_.size(); ++i) {
      sum += areas_[i] * value(i);
      area += areas_[i];
    }
    return area > 0 ? sum / area : 0;
  }
  double light_at(std::size_t i) const {
    return static_cast<double>((last_.direct[i] + last_.indirect[i]).sum()) / 3;
  }
  /// What errors count for, by texel.
  void weigh(double target, double mean) {
    weights_.assign(areas_.size(), 1.0);
    for (std::size_t i = 0; i < weights_.size(); ++i) {
      weights_[i] = 1 / lightmap::dim_share(light_at(i), mean, accuracy::dim_exponent(target));
    }
  }
  /// Root of the mean square, mean over channels, of a - b.
  double difference(const Light& a, const Light& b) const {
    return std::sqrt(mean([&](std::size_t i) {
      const Rgbd d = (to_double(a[i]) - to_double(b[i])) * weights_[i];
      return (d.r * d.r + d.g * d.g + d.b * d.b) / 3;
    }));
  }
  double mean_light() const {
    return mean([&](std::size_t i) { return light_at(i); });
  }

  const JobOptions& options_;
  const Prepared& p_;
  const LightmapPlaces& places_;
  const Progress& progress_;
  accuracy::SceneMeasure measure_;
  std::vector<std::uint8_t> selected_;  // texels
  std::vector<double> areas_;           // theirs
  std::vector<double> weights_;         // their errors'
  double whole_ = 1;                    // all texels over these
  StageClock own_;
  std::uint64_t runs_ = 0;
  Run last_;
  std::shared_ptr<const FirstStage> stage_;  // of the last run
};

}  // namespace

Result<Tuned> tune(const JobOptions& options, const Prepared& p, const LightmapPlaces& places,
                   double target, const Progress& progress, double patience) {
  progress.report("pilot", 0);
  return Tuner(options, p, places, progress).run(target, patience);
}

}  // namespace lightbatch::pipeline
