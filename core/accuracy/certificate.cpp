// Measured error with its interval. The product of residuals against two independent halves is an
// unbiased square (cross-validated variance); intervals by the bias-corrected and accelerated
// bootstrap (Efron 1987) over the probes.
#include "core/accuracy/certificate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"
#include "core/base/random.h"

namespace lightbatch::accuracy {
namespace {

constexpr std::size_t kFirstProbes = 512;
constexpr std::uint32_t kFirstPaths = 16;  // a half
constexpr std::size_t kResamples = 1000;
/// Half of 5 % on each side: what it takes to hold 95 % with skewed squares and a stop rule that
/// looks more than once (measured: 94 to 96 %).
constexpr double kTail = 0.0125;
/// Standard errors of the squared error that its upper end is above the estimate, at least.
constexpr double kNoiseDeviations = 2;
/// A decision is believed once the interval is this narrow against the larger of error and target.
constexpr double kNarrow = 0.5;

/// Bias, surely, over error, from which on the residuals are alike.
constexpr double kAlike = 0.1;

/// Share of the paths' noise in the residuals up to which more probes tell more than more paths:
/// squares of errors vary from texel to texel by several times their mean.
constexpr double kMostNoise = 0.75;

/// Sums of one probe's two halves.
struct Halves {
  std::array<Rgbd, 2> sum;
  std::uint32_t paths = 0;  // in each
  Rgbd mean(std::size_t half) const { return sum[half] / static_cast<double>(paths); }
};

/// What one probe adds to the sums that the figures are ratios of.
struct Term {
  double square = 0;    // (E - R1)(E - R2), sum over channels
  double residual = 0;  // E - R
  double truth = 0;     // R
};

double inverse_normal(double p) {
  // Acklam's rational approximation, relative error 1e-9; ample for a percentile.
  constexpr double a[] = {-3.969683028665376e+01, 2.209460984245205e+02,  -2.759285104469687e+02,
                          1.383577518672690e+02,  -3.066479806614716e+01, 2.506628277459239e+00};
  constexpr double b[] = {-5.447609879822406e+01, 1.615858368580409e+02, -1.556989798598866e+02,
                          6.680131188771972e+01, -1.328068155288572e+01};
  constexpr double c[] = {-7.784894002430293e-03, -3.223964580411365e-01, -2.400758277161838e+00,
                          -2.549732539343734e+00, 4.374664141464968e+00,  2.938163982698783e+00};
  constexpr double d[] = {7.784695709041462e-03, 3.224671290700398e-01, 2.445134137142996e+00,
                          3.754408661907416e+00};
  const auto tail = [&](double q) {
    return (((((c[0] * q + c[1]) * q + c[2]) * q + c[3]) * q + c[4]) * q + c[5]) /
           ((((d[0] * q + d[1]) * q + d[2]) * q + d[3]) * q + 1);
  };
  if (p < 0.02425) return tail(std::sqrt(-2 * std::log(p)));
  if (p > 1 - 0.02425) return -tail(std::sqrt(-2 * std::log(1 - p)));
  const double q = p - 0.5, r = q * q;
  return (((((a[0] * r + a[1]) * r + a[2]) * r + a[3]) * r + a[4]) * r + a[5]) * q /
         (((((b[0] * r + b[1]) * r + b[2]) * r + b[3]) * r + b[4]) * r + 1);
}
double normal_cdf(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

/// Mean squared error and bias, both against the mean truth; squared so that noise may carry the
/// estimate below zero and back.
struct Figures {
  double square = 0;  // signed relMSE
  double bias = 0;
  double mean = 0;  // of the truth
};
struct MeanRule {
  double map_mean = 0;  // of the values over the whole map, or 0
  double fallback = 0;  // where the truth is 0 everywhere
};
Figures figures_of(const Term& sum, double count, const MeanRule& rule) {
  double mean = sum.truth / count;
  if (rule.map_mean > 0) mean = std::max(mean / 2, rule.map_mean - sum.residual / count);
  if (!(mean > 0)) mean = rule.fallback;
  if (!(mean > 0)) return {};
  // square sums three channels, truth and residual are channel means.
  return {sum.square / (3 * count) / (mean * mean), sum.residual / count / mean, mean};
}

struct Weighted {
  double value = 0, weight = 0;
};

/// The value that `share` of the weight does not exceed.
double quantile(std::vector<Weighted> values, double share) {
  std::sort(values.begin(), values.end(),
            [](const Weighted& a, const Weighted& b) { return a.value < b.value; });
  double total = 0, below = 0;
  for (const Weighted& v : values) total += v.weight;
  for (const Weighted& v : values) {
    below += v.weight;
    if (below >= share * total) return v.value;
  }
  return values.back().value;
}

double root(double square) { return std::sqrt(std::max(0.0, square)); }

double deviation(const std::vector<double>& values) {
  double mean = 0, squares = 0;
  for (const double v : values) mean += v / static_cast<double>(values.size());
  for (const double v : values) squares += (v - mean) * (v - mean);
  return std::sqrt(squares / static_cast<double>(values.size()));
}

/// BCa interval of one figure.
std::array<double, 2> interval(std::vector<double> resampled, double estimate,
                               const std::vector<double>& jackknife) {
  std::sort(resampled.begin(), resampled.end());
  const double count = static_cast<double>(resampled.size());
  const auto below = static_cast<double>(
      std::lower_bound(resampled.begin(), resampled.end(), estimate) - resampled.begin());
  const double share = std::clamp(below / count, 1 / count, 1 - 1 / count);
  const double z0 = inverse_normal(share);
  double mean = 0, cubes = 0, squares = 0;
  for (const double v : jackknife) mean += v / static_cast<double>(jackknife.size());
  for (const double v : jackknife) {
    squares += (mean - v) * (mean - v);
    cubes += (mean - v) * (mean - v) * (mean - v);
  }
  const double acceleration = squares > 0 ? cubes / (6 * std::pow(squares, 1.5)) : 0;
  std::array<double, 2> ends{};
  for (std::size_t i = 0; i < 2; ++i) {
    const double z = z0 + inverse_normal(i == 0 ? kTail : 1 - kTail);
    const double p = normal_cdf(z0 + z / std::max(0.1, 1 - acceleration * z));
    const double place = std::clamp(p * count - 0.5, 0.0, count - 1);
    const auto lower = static_cast<std::size_t>(place);
    const std::size_t upper = std::min(lower + 1, resampled.size() - 1);
    const double part = place - static_cast<double>(lower);
    ends[i] = resampled[lower] * (1 - part) + resampled[upper] * part;
  }
  return ends;
}

Certificate judge(std::span<const Probe> probes, std::span<const Halves> halves, double map_mean,
                  std::uint64_t seed, double* noise_share) {
  Certificate result;
  const std::size_t count = halves.size();
  const double n = static_cast<double>(count);
  std::vector<Term> terms(count);
  std::vector<Weighted> sizes;
  Term total;
  double value_sum = 0, observed = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Rgbd value = to_double(probes[i].value);
    const Rgbd r1 = halves[i].mean(0), r2 = halves[i].mean(1), r = (r1 + r2) / 2.0;
    const Rgbd residual = value - r;
    const double weight = probes[i].weight;
    terms[i] = {weight * ((value - r1) * (value - r2)).sum(), weight * residual.sum() / 3,
                weight * r.sum() / 3};
    total.square += terms[i].square;
    total.residual += terms[i].residual;
    total.truth += terms[i].truth;
    value_sum += weight * value.sum() / 3;
    observed += weight * (residual * residual).sum();
    for (const double d : {residual.r, residual.g, residual.b}) {
      sizes.push_back({std::abs(d), weight});
    }
  }
  if (!std::isfinite(total.square) || !std::isfinite(total.residual)) {
    result.relrmse = std::numeric_limits<double>::quiet_NaN();
    return result;
  }
  const MeanRule rule{map_mean, value_sum / n};
  const Figures figures = figures_of(total, n, rule);
  result.relrmse = root(figures.square);
  result.bias = figures.bias;
  result.probes = count;
  result.mean_irradiance = total.truth > 0 ? figures.mean : 0;
  for (const Halves& h : halves) result.paths += 2 * h.paths;

  std::vector<double> jack_square(count), jack_bias(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Term rest{total.square - terms[i].square, total.residual - terms[i].residual,
                    total.truth - terms[i].truth};
    const Figures f = figures_of(rest, std::max(1.0, n - 1), rule);
    jack_square[i] = f.square;
    jack_bias[i] = f.bias;
  }
  std::vector<double> squares(kResamples), biases(kResamples);
  parallel_for(kResamples, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      Random random(item_seed(seed, b, 3));
      Term sum;
      for (std::size_t i = 0; i < count; ++i) {
        const Term& t = terms[random.below(count)];
        sum.square += t.square;
        sum.residual += t.residual;
        sum.truth += t.truth;
      }
      const Figures f = figures_of(sum, n, rule);
      squares[b] = f.square;
      biases[b] = f.bias;
    }
  });
  // Where light comes by rare bright paths, few of the halves hold one: products are negative for
  // want of the other half, and their interval may end below nothing. The error is known no better
  // than that noise, and is no smaller than its own mean.
  const double least_high = std::max(0.0, figures.square) + kNoiseDeviations * deviation(squares);
  const auto error_ends = interval(std::move(squares), figures.square, jack_square);
  const auto bias_ends = interval(std::move(biases), figures.bias, jack_bias);
  const double sure_bias = std::max({0.0, bias_ends[0], -bias_ends[1]});
  result.relrmse = std::max(result.relrmse, sure_bias);
  result.low = std::max(root(error_ends[0]), sure_bias);
  result.high = std::max({root(error_ends[1]), root(least_high), result.relrmse});
  result.bias_low = bias_ends[0];
  result.bias_high = bias_ends[1];

  const double true_share = observed > 0 ? std::clamp(total.square / observed, 0.0, 1.0) : 0;
  if (figures.mean > 0) {
    result.p95 = quantile(std::move(sizes), 0.95) * std::sqrt(true_share) / figures.mean;
  }
  *noise_share = 1 - true_share;
  return result;
}

/// All residuals alike: either the map is biased, or its light comes by rare bright paths, and no
/// path has met any yet.
bool too_bright(const Certificate& c) { return c.bias_low > kAlike * c.relrmse; }

}  // namespace

Result<Certificate> certify(const PathTracer& tracer, std::span<const Probe> probes,
                            const CertificateOptions& options, const Progress& progress) {
  Certificate result;
  if (probes.empty()) return result;
  std::vector<Halves> halves;
  std::size_t used = std::min(probes.size(), kFirstProbes);
  std::uint32_t goal = kFirstPaths;
  std::uint64_t spent = 0;
  bool in_doubt = false;
  // Within the budget from the start: fewer probes rather than fewer paths each.
  used = std::clamp<std::size_t>(options.max_paths / (2 * kFirstPaths), 1, used);
  for (std::uint32_t round = 0;; ++round) {
    halves.resize(used);
    constexpr std::size_t kChunk = 64;
    for (std::size_t start = 0; start < used; start += kChunk) {
      if (progress.cancelled()) return cancelled();
      progress.report("certify",
                      static_cast<double>(spent) /
                          static_cast<double>(std::max<std::uint64_t>(1, options.max_paths)));
      const std::size_t chunk = std::min(kChunk, used - start);
      parallel_for(chunk, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = start + begin; i < start + end; ++i) {
          Halves& h = halves[i];
          const std::uint32_t more = goal - h.paths;
          if (more == 0) continue;
          for (std::uint64_t half = 0; half < 2; ++half) {
            const std::uint64_t seed = item_seed(options.seed, 2 * i + half, 16 + round);
            h.sum[half] += tracer.irradiance(probes[i].points, more, seed).irradiance *
                           static_cast<double>(more);
          }
          h.paths = goal;
        }
      });
      spent = 0;
      for (const Halves& h : halves) spent += 2 * h.paths;
    }
    double noise_share = 0;
    result =
        judge(probes, halves, options.map_mean, item_seed(options.seed, round, 4), &noise_share);
    if (!std::isfinite(result.relrmse)) {
      return Status(StatusCode::kInternal, "LIGHT_NOT_FINITE",
                    "the light of the map, or of the paths that judge it, is not finite; please "
                    "report this scene");
    }
    const double scale = std::max(result.relrmse, options.target);
    const bool decided =
        result.high <= options.target ||
        (result.low > options.target && (spent > options.max_paths / 2 || !too_bright(result)));
    if (decided && result.high - result.low <= kNarrow * scale) break;
    // Twice the probes, or twice the paths of each: whichever the residuals are short of.
    const bool more_probes = 2 * used <= probes.size() && noise_share < kMostNoise;
    const std::uint64_t next = more_probes ? 2 * used : used;
    const std::uint32_t next_goal = more_probes ? goal : 2 * goal;
    // Not let go of at the first estimate below: that would let every other bad map pass.
    in_doubt = in_doubt || (spent > options.max_paths / 2 && result.relrmse > options.target &&
                            result.low <= options.target);
    const double most =
        static_cast<double>(options.max_paths) * (in_doubt ? options.budgets_in_doubt : 1.0);
    if (static_cast<double>(2 * next * next_goal) > most || next_goal > (1u << 24)) break;
    used = next;
    goal = next_goal;
  }
  result.met = result.high <= options.target;
  result.missed = result.low > options.target;
  progress.report("certify", 1);
  return result;
}

}  // namespace lightbatch::accuracy
