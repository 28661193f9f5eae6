#include "core/accuracy/tuning.h"

#include <algorithm>
#include <cmath>

namespace lightbatch::accuracy {

double error_at(const PartPilot& pilot, double rung) {
  return pilot.rung > 0 ? pilot.error * std::pow(rung / pilot.rung, pilot.growth.error) : 0.0;
}

double cost_at(const PartPilot& pilot, double rung) {
  return rung > 0 ? pilot.cost * std::pow(pilot.rung / rung, pilot.growth.cost) : pilot.cost;
}

double rung_for(const PartPilot& pilot, double error) {
  return pilot.error > 0 ? pilot.rung * std::pow(error / pilot.error, 1 / pilot.growth.error)
                         : kCoarsestRung;
}

Growth growth_between(const PartPilot& coarse, const PartPilot& fine) {
  constexpr double kApart = 1.5;
  Growth growth = fine.growth;
  if (!(fine.rung > 0) || coarse.rung < kApart * fine.rung) return growth;
  const double rungs = std::log(coarse.rung / fine.rung);
  // Either error is itself an estimate: what is known of all scenes counts as much.
  const auto with_usual = [](double measured, double usual) { return 0.5 * (measured + usual); };
  if (coarse.error > 0 && fine.error > 0) {
    growth.error = with_usual(std::clamp(std::log(coarse.error / fine.error) / rungs, 0.5, 1.1),
                              fine.growth.error);
  }
  if (coarse.cost > 0 && fine.cost > 0) {
    growth.cost = std::clamp(std::log(fine.cost / coarse.cost) / rungs, 0.7, 1.8);
  }
  return growth;
}

Rungs choose_rungs(double target, double allowed, const PartPilot& direct,
                   const PartPilot& indirect) {
  // The rung of a part that may bring this share of the square.
  const auto rung_of = [&](const PartPilot& p, double share) {
    return std::clamp(rung_for(p, allowed * std::sqrt(share)), kFinestRung, kCoarsestRung);
  };
  if (!(direct.error > 0) || !(indirect.error > 0)) {
    return {target, rung_of(direct, 1), rung_of(indirect, 1)};
  }
  // Bisection on the share of the square that direct light may bring: its marginal price falls with
  // the share, the other's rises.
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double share = 0.5 * (low + high);
    const auto price = [&](const PartPilot& p, double part) {
      const double rung = rung_for(p, allowed * std::sqrt(part));
      return p.growth.cost / p.growth.error * cost_at(p, rung) / part;
    };
    (price(direct, share) > price(indirect, 1 - share) ? low : high) = share;
  }
  const double share = 0.5 * (low + high);
  return {target, rung_of(direct, share), rung_of(indirect, 1 - share)};
}

}  // namespace lightbatch::accuracy
