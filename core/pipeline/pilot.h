#pragma once

#include "core/accuracy/tuning.h"
#include "core/pipeline/light_stage.h"

namespace lightbatch::pipeline {

/// The first stage is never read at a coarser rung: of elements as large as the room, every hit
/// would be near, and light come by walks alone.
constexpr double kCoarsestStage = 0.10;

/// What baking a small share of the texels told about the whole.
struct Pilot {
  /// Indirect: the error is that of first stage and gather together, rung and cost are the
  /// gather's.
  accuracy::PartPilot direct, indirect;
  double stage_rung = 0, stage_rays = 0;  // of the first stage
  /// Measured error over that from the runs' difference; in the parts' errors already.
  double excess = 1;
  /// Wall seconds of the whole map at the pilot's rungs.
  double direct_seconds = 0, stage_seconds = 0, gather_seconds = 0, directional_seconds = 0;
  double seconds_a_path = 0;  // of a certificate
};

/// The cheapest rungs that meet a target, with room for what a pilot does not see. The first stage
/// takes a fixed part of the gather's rays, but is never read at a finer rung than the gather, nor
/// at one much coarser: where it leaves less than rays do nothing is lost that counts, where it
/// leaves more, finer rungs refine it too.
accuracy::Rungs rungs_for(const Pilot& pilot, double target);

/// relRMSE expected at other rungs.
double error_at(const Pilot& pilot, const accuracy::Rungs& rungs);
/// Rays of the bake at other rungs.
double rays_at(const Pilot& pilot, const accuracy::Rungs& rungs);
/// Wall seconds of first stage and texels at other rungs; of the first stage alone.
double seconds_at(const Pilot& pilot, const accuracy::Rungs& rungs);
double stage_seconds_at(const Pilot& pilot, const accuracy::Rungs& rungs);

}  // namespace lightbatch::pipeline
