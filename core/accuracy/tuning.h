#pragma once

#include <span>
#include <vector>

#include "core/accuracy/settings.h"

namespace lightbatch::accuracy {

/// How error falls and cost grows as a part is read at finer rungs: error ~ rung^error,
/// cost ~ rung^-cost.
struct Growth {
  double error = 1;
  double cost = 1;
};
/// Samples of edges converge as N^-3/4.
constexpr Growth kDirectGrowth{1.0, 4.0 / 3.0};
/// First stage and gather together, cost of the gather alone; measured: error falls as rays^-0.5
/// where a few bright patches light a room, as rays^-0.75 in even light.
constexpr Growth kIndirectGrowth{0.7, 1.2};

/// What a pilot measured of one part of the light at one place of the ladder.
struct PartPilot {
  double rung = 0;   // nominal error that the settings were read at
  double error = 0;  // relRMSE that the part brings there
  double cost = 0;   // rays of the whole map there
  Growth growth;
};

/// How a part grows on this scene, from pilots at a coarse and a fine rung; what they cannot tell
/// (rungs less than a factor of 1.5 apart, no error) stays as it is in `fine`, the usual growth.
/// Measured within [0.5, 1.1] and [0.7, 1.8], beyond which noise speaks; of error, the mean of the
/// measured and the usual.
Growth growth_between(const PartPilot& coarse, const PartPilot& fine);

/// A part to choose a rung for, within limits.
struct PartChoice {
  PartPilot pilot;
  double finest = kFinestRung, coarsest = kCoarsestRung;
};

/// The cheapest rungs, one for each part, whose errors add (in squares) to `allowed`, or come as
/// near as the limits let them; at the optimum the squares stand as cost times growth.cost /
/// growth.error (Lagrange). A part without error is read at its coarsest rung.
std::vector<double> choose_rungs(double allowed, std::span<const PartChoice> parts);

/// Error and cost of a part when read at another rung.
double error_at(const PartPilot& pilot, double rung);
double cost_at(const PartPilot& pilot, double rung);

}  // namespace lightbatch::accuracy
