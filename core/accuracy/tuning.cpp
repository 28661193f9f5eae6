#include "core/accuracy/tuning.h"

#include <algorithm>
#include <cmath>

namespace lightbatch::accuracy {

double error_at(const PartPilot& pilot, double rung) {
  return pilot.rung > 0 ? pilot.error * rung / pilot.rung : 0.0;
}

double cost_at(const PartPilot& pilot, double rung, double power) {
  return rung > 0 ? pilot.cost * std::pow(pilot.rung / rung, power) : pilot.cost;
}

Rungs choose_rungs(double target, double allowed, const PartPilot& direct,
                   const PartPilot& indirect) {
  const auto within = [](double rung) { return std::clamp(rung, kFinestRung, kCoarsestRung); };
  const auto alone = [&](const PartPilot& p) {
    return p.error > 0 ? within(p.rung * allowed / p.error) : kCoarsestRung;
  };
  if (!(direct.error > 0) || !(indirect.error > 0)) {
    return {target, alone(direct), alone(indirect)};
  }
  // Bisection on the share of the square that direct light may bring: its marginal price falls with
  // the share, the other's rises.
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double share = 0.5 * (low + high);
    const double d = direct.rung * allowed * std::sqrt(share) / direct.error;
    const double n = indirect.rung * allowed * std::sqrt(1 - share) / indirect.error;
    const double price_direct = kDirectPower * cost_at(direct, d, kDirectPower) / share;
    const double price_indirect =
        kIndirectPower * cost_at(indirect, n, kIndirectPower) / (1 - share);
    (price_direct > price_indirect ? low : high) = share;
  }
  const double share = 0.5 * (low + high);
  return {target, within(direct.rung * allowed * std::sqrt(share) / direct.error),
          within(indirect.rung * allowed * std::sqrt(1 - share) / indirect.error)};
}

}  // namespace lightbatch::accuracy
