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

std::vector<double> choose_rungs(double allowed, std::span<const PartChoice> parts) {
  std::vector<double> rungs(parts.size());
  // At one price of a square's last share; rungs coarsen as it falls. The sum of squares.
  const auto choose = [&](double price) {
    double squares = 0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const PartPilot& p = parts[i].pilot;
      rungs[i] = parts[i].coarsest;
      if (!(p.error > 0)) continue;
      // growth.cost / growth.error * cost / error^2 = price, solved for the rung. Where no cost is
      // known, the pilot's own rung.
      const double at_pilot = p.growth.cost / p.growth.error * p.cost / (p.error * p.error);
      const double times =
          p.cost > 0 ? std::pow(at_pilot / price, 1 / (p.growth.cost + 2 * p.growth.error)) : 1.0;
      rungs[i] = std::clamp(p.rung * times, parts[i].finest, parts[i].coarsest);
      const double error = error_at(p, rungs[i]);
      squares += error * error;
    }
    return squares;
  };
  // Bisection on the logarithm of the price, over all that doubles hold of it.
  double low = -300, high = 300;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (choose(std::pow(10.0, middle)) > allowed * allowed ? low : high) = middle;
  }
  choose(std::pow(10.0, high));
  return rungs;
}

}  // namespace lightbatch::accuracy
