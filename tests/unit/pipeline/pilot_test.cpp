#include "core/pipeline/pilot.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace lightbatch::pipeline {
namespace {

Pilot furnished_room() {
  Pilot pilot;
  pilot.direct = {0.05, 0.01, 1e6, accuracy::kDirectGrowth};
  pilot.indirect = {0.08, 0.06, 1e7, accuracy::kIndirectGrowth};
  pilot.stage_rung = 0.15;
  pilot.stage_rays = 1e6;
  pilot.stage_seconds = 1;
  return pilot;
}

TEST(Pilot, ExpectsLessThanTheTarget) {
  const Pilot pilot = furnished_room();
  for (const double target : {0.2, 0.05, 0.02, 0.01, 0.005}) {
    const accuracy::Rungs rungs = rungs_for(pilot, target);
    // Three quarters, half at 1 % and below; less where direct light is read at the target's rung.
    EXPECT_LE(error_at(pilot, rungs), (target > 0.015 ? 0.75 : 0.5) * target * (1 + 1e-9))
        << target;
    EXPECT_LE(rungs.direct, target);
  }
}

TEST(Pilot, TheFirstStageTakesAShareOfTheRaysAndIsNeverFinerThanTheGather) {
  const Pilot pilot = furnished_room();
  for (const double target : {0.3, 0.05, 0.02, 0.005, 0.001}) {
    const accuracy::Rungs rungs = rungs_for(pilot, target);
    EXPECT_GE(rungs.first, std::min(rungs.gather, kCoarsestStage)) << target;
    EXPECT_LE(rungs.first, kCoarsestStage) << target;
    EXPECT_LE(stage_seconds_at(pilot, rungs),
              stage_seconds_at(pilot, rungs_for(pilot, target / 2)));
  }
  Pilot many_texels = pilot;
  many_texels.indirect.cost *= 1000;
  const accuracy::Rungs rungs = rungs_for(many_texels, 0.05);
  EXPECT_DOUBLE_EQ(rungs.first, rungs.gather);
}

TEST(Pilot, ASceneWithoutIndirectLightIsReadCoarsely) {
  Pilot pilot = furnished_room();
  pilot.indirect.error = pilot.indirect.cost = pilot.stage_rays = 0;
  const accuracy::Rungs rungs = rungs_for(pilot, 0.02);
  EXPECT_EQ(rungs.gather, accuracy::kCoarsestRung);
  EXPECT_EQ(rungs.first, kCoarsestStage);
  EXPECT_EQ(stage_seconds_at(pilot, rungs), 0);
}

}  // namespace
}  // namespace lightbatch::pipeline
