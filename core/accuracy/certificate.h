#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/accuracy/path_tracer.h"
#include "core/base/progress.h"
#include "core/base/status.h"
#include "core/math/rgb.h"

namespace lightbatch::accuracy {

/// A texel to be judged: its value, and the points of the surface it covers.
struct Probe {
  Rgb value;  // lux
  PointSource points;
  double weight = 1;  // area-uniform density of probes over that which it was drawn by
};

struct CertificateOptions {
  double target = 0.02;                 // relRMSE that the map should keep
  std::uint64_t max_paths = 4'000'000;  // budget
  /// Budgets that may be spent while the map seems to miss its target and may yet keep it.
  double budgets_in_doubt = 1;
  std::uint64_t seed = 1;
  /// Mean value of the whole map, by area and over channels, lux; 0: not known. With it, mean R is
  /// this less the mean residual of the probes, far steadier than the mean of a few hundred R.
  double map_mean = 0;
};

/// Error of a map, measured by an independent estimator. With E the value and R the truth of
/// area-uniform texels, over three channels:
///   relRMSE = sqrt(mean (E - R)^2) / mean R, bias = mean (E - R) / mean R.
/// R is known with noise only; two independent halves R1, R2 make mean (E - R1)(E - R2) an unbiased
/// estimate of mean (E - R)^2. low..high and bias_low..bias_high are 95 % intervals (bootstrap over
/// the probes). p95 of |E - R| / mean R: the observed residuals scaled down by the noise's share.
struct Certificate {
  double relrmse = 0, low = 0, high = 0;
  double p95 = 0;
  double bias = 0, bias_low = 0, bias_high = 0;
  std::uint64_t probes = 0;
  std::uint64_t paths = 0;
  double mean_irradiance = 0;  // lux, mean over channels
  /// The interval lies wholly below (met) or above (missed) the target; neither: undecided.
  bool met = false;
  bool missed = false;
};

/// Spends paths until the interval decides against the target or the budget is gone; of a map that
/// seems too bright everywhere, half the budget before it is missed, as its light may come by rare
/// paths. The probes must be drawn in random order, by area or by what their weights say (Horvitz
/// and Thompson 1952): a prefix of them may be used. The same result for the same arguments on any
/// number of threads. CANCELLED when asked to stop.
Result<Certificate> certify(const PathTracer& tracer, std::span<const Probe> probes,
                            const CertificateOptions& options, const Progress& progress);

}  // namespace lightbatch::accuracy
