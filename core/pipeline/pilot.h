#pragma once

#include "core/accuracy/tuning.h"
#include "core/pipeline/light_stage.h"

namespace lightbatch::pipeline {

/// What baking a small share of the texels told about the whole.
struct Pilot {
  accuracy::PartPilot direct, indirect;
  /// Measured error over that from the runs' difference; in the parts' errors already.
  double excess = 1;
  /// Wall seconds of the whole map at the pilot's rungs, and of the pilot itself.
  double solve_seconds = 0, direct_seconds = 0, gather_seconds = 0;
  double own_seconds = 0;
  double seconds_a_path = 0;                // of a certificate
  std::shared_ptr<const FirstStage> first;  // at the pilot's rungs
};

/// The cheapest rungs that meet a target, with room for what a pilot does not see.
accuracy::Rungs rungs_for(const Pilot& pilot, double target);

/// Pilot and choice for one target: light of a fixed small share of the texels is baked twice, from
/// other random numbers, the second time at the target's own rungs or near them; where the choice
/// falls far from these, a third time there. The runs' difference tells the error of both, path
/// tracing what is wrong in both. Apart from the seconds, the same on every run. CANCELLED.
struct Tuned {
  accuracy::Rungs rungs;
  Pilot pilot;
  /// The pilot's first stage where it is good enough for the rungs.
  std::shared_ptr<const FirstStage> first;
  double seconds = 0;  // wall, of all its pilots
};
Result<Tuned> tune(const JobOptions& options, const Prepared& p, const LightmapPlaces& places,
                   double target, const Progress& progress);

/// relRMSE expected at other rungs.
double error_at(const Pilot& pilot, const accuracy::Rungs& rungs);
/// Rays of the bake at other rungs.
double rays_at(const Pilot& pilot, const accuracy::Rungs& rungs);
/// Wall seconds of first stage and texels at other rungs; of the first stage alone.
double seconds_at(const Pilot& pilot, const accuracy::Rungs& rungs);
double solve_seconds_at(const Pilot& pilot, const accuracy::Rungs& rungs);

}  // namespace lightbatch::pipeline
