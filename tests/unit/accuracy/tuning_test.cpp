#include "core/accuracy/tuning.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lightbatch::accuracy {
namespace {

constexpr double kAllowed = 0.015;
const PartPilot kDirect{0.02, 0.01, 1e6, kDirectGrowth};
const PartPilot kIndirect{0.02, 0.03, 2e7, kIndirectGrowth};

TEST(Tuning, TheChoiceUsesUpWhatIsAllowed) {
  const PartChoice parts[] = {{kDirect}, {kIndirect}};
  const auto rungs = choose_rungs(kAllowed, parts);
  // By the model exactly; equality up to the bisection's last step.
  EXPECT_NEAR(std::hypot(error_at(kDirect, rungs[0]), error_at(kIndirect, rungs[1])), kAllowed,
              1e-12);
}

TEST(Tuning, NoOtherSplitIsCheaper) {
  const PartPilot third{0.05, 0.008, 3e6, {0.6, 1.3}};
  const PartChoice parts[] = {{kDirect}, {kIndirect}, {third}};
  const auto best = choose_rungs(kAllowed, parts);
  const auto price = [&](double direct, double indirect, double other) {
    return cost_at(kDirect, direct) + cost_at(kIndirect, indirect) + cost_at(third, other);
  };
  // The rung at which a part brings an error.
  const auto rung = [](const PartPilot& p, double error) {
    return p.rung * std::pow(error / p.error, 1 / p.growth.error);
  };
  const double least = price(best[0], best[1], best[2]);
  for (int i = 1; i < 50; ++i) {
    for (int k = 1; i + k < 50; ++k) {
      const double a = i / 50.0, b = k / 50.0;
      EXPECT_GE(
          price(rung(kDirect, kAllowed * std::sqrt(a)), rung(kIndirect, kAllowed * std::sqrt(b)),
                rung(third, kAllowed * std::sqrt(1 - a - b))),
          least * (1 - 1e-9))
          << a << " " << b;
    }
  }
}

TEST(Tuning, ALimitedPartLeavesTheRestToTheOthers) {
  const PartChoice parts[] = {{kDirect, 0.02, 0.02}, {kIndirect}};
  const auto rungs = choose_rungs(kAllowed, parts);
  EXPECT_EQ(rungs[0], 0.02);
  EXPECT_NEAR(std::hypot(error_at(kDirect, 0.02), error_at(kIndirect, rungs[1])), kAllowed, 1e-12);
}

TEST(Tuning, APartWithoutErrorIsReadCoarsely) {
  const PartPilot none{0.02, 0, 0, {1, 1}}, some{0.02, 0.03, 2e7, {1, 1}};
  const PartChoice parts[] = {{none}, {some}};
  const auto rungs = choose_rungs(kAllowed, parts);
  EXPECT_EQ(rungs[0], kCoarsestRung);
  EXPECT_NEAR(rungs[1], 0.01, 1e-12);
}

TEST(Tuning, APartOfUnknownCostStaysWhereItIs) {
  const PartPilot unpriced{0.02, 0.01, 0, {1, 1}};
  const PartChoice parts[] = {{unpriced}, {kIndirect}};
  const auto rungs = choose_rungs(kAllowed, parts);
  EXPECT_EQ(rungs[0], 0.02);
  EXPECT_NEAR(std::hypot(0.01, error_at(kIndirect, rungs[1])), kAllowed, 1e-12);
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
  const PartPilot large{0.02, 0.5, 1e6, {1, 1}};
  const PartChoice parts[] = {{large}, {large}};
  for (const double rung : choose_rungs(1e-9, parts)) EXPECT_EQ(rung, kFinestRung);
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
