#pragma once

#include "core/accuracy/settings.h"

namespace lightbatch::accuracy {

/// What a pilot measured of one part of the light at one place of the ladder.
struct PartPilot {
  double rung = 0;   // nominal error that the settings were read at
  double error = 0;  // relRMSE that the part brings there
  double cost = 0;   // rays of the whole map there
};

/// How cost grows as a part's error falls: samples of edges converge as N^-3/4, gather rays and
/// elements together as N^-0.77.
constexpr double kDirectPower = 4.0 / 3.0;
constexpr double kIndirectPower = 1.3;

/// The cheapest rungs whose errors add (in squares) to `allowed`: error ~ rung, cost ~
/// rung^-power for each part; at the optimum the squares stand as power times cost (Lagrange). Each
/// within the ladder. A part without error is read at the coarsest rung.
Rungs choose_rungs(double target, double allowed, const PartPilot& direct,
                   const PartPilot& indirect);

/// Error and cost of a part when read at another rung.
double error_at(const PartPilot& pilot, double rung);
double cost_at(const PartPilot& pilot, double rung, double power);

}  // namespace lightbatch::accuracy
