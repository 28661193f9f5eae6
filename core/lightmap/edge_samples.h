#pragma once

#include <algorithm>
#include <cmath>

namespace lightbatch::lightmap {

/// Owen-Sobol samples of a visibility edge have a standard error of about this times N^-0.75.
constexpr double kEdgeError = 0.5;

/// Range of unshadowed light that a pilot's points even out, of the allowed error.
constexpr double kMostUneven = 4;

/// Of the mean of N samples whose error is constant * N^-0.75.
inline double edge_error(int samples, double constant = kEdgeError) {
  return constant * std::pow(samples, -0.75);
}

/// Samples of light that is seen in part, so that the error is `allowed` (the same unit), from 1 to
/// `most`.
inline int samples_for_edge(double light, double allowed, double constant, int most) {
  if (!(allowed > 0)) return most;
  const double wanted = std::pow(constant * light / allowed, 4.0 / 3.0);
  return static_cast<int>(std::clamp(wanted, 1.0, static_cast<double>(most)));
}

}  // namespace lightbatch::lightmap
