#include "core/accuracy/tuning.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lightbatch::accuracy {
namespace {

double price(const PartPilot& direct, const PartPilot& indirect, double d, double n) {
  return cost_at(direct, d) + cost_at(indirect, n);
}

TEST(Tuning, TheChoiceUsesUpWhatIsAllowed) {
  const PartPilot direct{0.02, 0.01, 1e6, kDirectGrowth};
  const PartPilot indirect{0.02, 0.03, 2e7, kIndirectGrowth};
  const Rungs rungs = choose_rungs(0.02, 0.015, direct, indirect);
  // By the model exactly; equality up to rounding.
  EXPECT_NEAR(std::hypot(error_at(direct, rungs.direct), error_at(indirect, rungs.indirect)), 0.015,
              1e-12);
}

TEST(Tuning, NoOtherSplitIsCheaper) {
  const PartPilot direct{0.02, 0.01, 1e6, kDirectGrowth};
  const PartPilot indirect{0.02, 0.03, 2e7, kIndirectGrowth};
  const double allowed = 0.015;
  const Rungs best = choose_rungs(0.02, allowed, direct, indirect);
  const double least = price(direct, indirect, best.direct, best.indirect);
  for (int i = 1; i < 100; ++i) {
    const double share = i / 100.0;
    const double d = rung_for(direct, allowed * std::sqrt(share));
    const double n = rung_for(indirect, allowed * std::sqrt(1 - share));
    EXPECT_GE(price(direct, indirect, d, n), least * (1 - 1e-9)) << share;
  }
}

TEST(Tuning, APartWithoutErrorIsReadCoarsely) {
  const Rungs rungs = choose_rungs(0.02, 0.015, {0.02, 0, 0, {1, 1}}, {0.02, 0.03, 2e7, {1, 1}});
  EXPECT_EQ(rungs.direct, kCoarsestRung);
  EXPECT_NEAR(rungs.indirect, 0.01, 1e-12);
}

TEST(Tuning, GrowthComesFromTwoPilots) {
  // Error x0.5 and cost x3 for a rung x0.4.
  const Growth g =
      growth_between({0.1, 0.06, 1e6, kIndirectGrowth}, {0.04, 0.03, 3e6, kIndirectGrowth});
  EXPECT_NEAR(g.error, 0.5 * (std::log(2) / std::log(2.5) + kIndirectGrowth.error), 1e-12);
  EXPECT_NEAR(g.cost, std::log(3) / std::log(2.5), 1e-12);
  // Too near each other, or nothing to divide: as before.
  EXPECT_EQ(growth_between({0.05, 0.06, 1e6, {}}, {0.04, 0.03, 3e6, kIndirectGrowth}).error,
            kIndirectGrowth.error);
  EXPECT_EQ(growth_between({0.1, 0, 1e6, {}}, {0.04, 0.03, 3e6, kIndirectGrowth}).error,
            kIndirectGrowth.error);
  EXPECT_NEAR(growth_between({0.1, 9, 1e6, {}}, {0.04, 0.03, 3e6, {0.7, 1}}).error, 0.9, 1e-12);
}

TEST(Tuning, StaysOnTheLadder) {
  const Rungs hopeless =
      choose_rungs(0.02, 1e-9, {0.02, 0.5, 1e6, {1, 1}}, {0.02, 0.5, 1e6, {1, 1}});
  EXPECT_EQ(hopeless.direct, kFinestRung);
  EXPECT_EQ(hopeless.indirect, kFinestRung);
}

TEST(Settings, FinerRungsAskForMoreOfEverything) {
  const SceneMeasure scene{100.0, 100'000};
  BakeSettings before = settings_for(kCoarsestRung, scene, 1);
  for (const double target : {0.2, 0.1, 0.04, 0.02, 0.007, 0.003, 0.001, kFinestRung}) {
    const BakeSettings s = settings_for(target, scene, 1);
    EXPECT_LT(s.elements.edge, before.elements.edge) << target;
    EXPECT_GE(s.solver.rays, before.solver.rays) << target;
    EXPECT_GT(s.gather.rays, before.gather.rays) << target;
    EXPECT_LT(s.gather.direct_error, before.gather.direct_error) << target;
    EXPECT_LT(s.gather.tolerance, before.gather.tolerance) << target;
    before = s;
  }
  // Beyond its ends the ladder holds still.
  EXPECT_EQ(settings_for(1e-6, scene, 1).gather.rays, before.gather.rays);
}

}  // namespace
}  // namespace lightbatch::accuracy
