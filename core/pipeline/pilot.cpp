#include "core/pipeline/pilot.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/lightmap/directional.h"

namespace lightbatch::pipeline {
namespace {

using accuracy::Rungs;

/// The error aimed at, against the target: the pilot's own error and the certificate's must fit
/// between. Who asks for 1 % or less reads values off single texels: two standard errors of these
/// must fit.
constexpr double kAim = 0.75, kFineAim = 0.5;
constexpr double kCoarseTarget = 0.02, kFineTarget = 0.01;
/// Direct light is read at the target's own rung at most: edges of shadows are few, so that a map's
/// error hardly knows of them, but they are looked at. No part is read at a finer rung than the
/// share: what has not fallen by then does not fall with rays.
constexpr double kMostCare = 1.0 / 12;
/// Rays of the first stage over the gather's.
constexpr double kStageShare = 0.2;
/// Its rung over the gather's, at most: where texels are few against elements, the share is small,
/// and what the first stage leaves would have to be made up for by rays.
constexpr double kStageBehind = 2.0;
/// Its rays grow as the rung to minus this: elements and stored rays of the ladder between 5 and
/// 2 %. At coarser rungs the ladder is steeper, but triangles, one element each at least, are not.
constexpr double kStageGrowth = 1.3;

double aim(double target) {
  const double t =
      std::clamp(std::log(target / kFineTarget) / std::log(kCoarseTarget / kFineTarget), 0.0, 1.0);
  return target * (kFineAim + (kAim - kFineAim) * t);
}

double stage_rays_at(const Pilot& pilot, double rung) {
  return pilot.stage_rays * std::pow(pilot.stage_rung / rung, kStageGrowth);
}

/// What a part costs at another rung, over what it cost its pilot.
double times(const accuracy::PartPilot& part, double rung) {
  return part.cost > 0 ? accuracy::cost_at(part, rung) / part.cost : 1.0;
}

}  // namespace

Rungs rungs_for(const Pilot& pilot, double target) {
  const double finest = std::max(kMostCare * target, accuracy::kFinestRung);
  const double coarsest = std::min(target, accuracy::kCoarsestRung);
  const std::array<accuracy::PartChoice, 2> parts{
      {{pilot.direct, std::min(finest, coarsest), coarsest}, {pilot.indirect, finest}}};
  const auto rungs = accuracy::choose_rungs(aim(target), parts);
  const double rays = kStageShare * accuracy::cost_at(pilot.indirect, rungs[1]);
  const double stage = rays > 0 && pilot.stage_rays > 0
                           ? pilot.stage_rung * std::pow(pilot.stage_rays / rays, 1 / kStageGrowth)
                           : kCoarsestStage;
  const double most = std::min(kCoarsestStage, kStageBehind * rungs[1]);
  return {target, rungs[0], std::clamp(stage, std::min(rungs[1], most), most), rungs[1]};
}

double error_at(const Pilot& pilot, const Rungs& rungs) {
  return std::hypot(accuracy::error_at(pilot.direct, rungs.direct),
                    accuracy::error_at(pilot.indirect, rungs.gather));
}

double rays_at(const Pilot& pilot, const Rungs& rungs) {
  return accuracy::cost_at(pilot.direct, rungs.direct) +
         accuracy::cost_at(pilot.indirect, rungs.gather) + stage_rays_at(pilot, rungs.first);
}

double stage_seconds_at(const Pilot& pilot, const Rungs& rungs) {
  return pilot.stage_rays > 0
             ? pilot.stage_seconds * stage_rays_at(pilot, rungs.first) / pilot.stage_rays
             : 0.0;
}

double seconds_at(const Pilot& pilot, const Rungs& rungs) {
  const auto directional = [](double rung) {
    const Rungs at{rung, rung, rung, rung};
    return lightmap::directional_rays(accuracy::settings_for(at, {}, 0).gather.rays);
  };
  return stage_seconds_at(pilot, rungs) +
         pilot.directional_seconds * directional(rungs.gather) / directional(pilot.indirect.rung) +
         pilot.gather_seconds * times(pilot.indirect, rungs.gather) +
         pilot.direct_seconds * times(pilot.direct, rungs.direct);
}

}  // namespace lightbatch::pipeline
