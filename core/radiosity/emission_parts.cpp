#include "core/radiosity/emission_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/random.h"
#include "core/math/sampling.h"

namespace lightbatch::radiosity {
namespace {

/// Parts are even where what they hold differs from their mean by this share of the triangle's;
/// half as large ones by root 2 times as much: unevenness of small parts shows from close by only.
constexpr float kEvenShare = 0.05f;
constexpr float kEvenGrowth = 1.41421356f;
/// A triangle is cut so often at most, and until parts hold no more than this share of a texel.
constexpr int kMostCuts = 4;
constexpr double kTexelsOfPart = 1.0 / 64;
/// A part that holds more than this share of the triangle's light is cut on, until it is so small.
constexpr double kMuch = 1.0 / 256;
constexpr int kMostFurtherCuts = 8;
constexpr double kMostFurtherParts = 1024;
/// Samples of the finest parts, each way; of uneven ones up to so many, as the scene's allow.
constexpr int kSamples = 8, kMostSamples = 64;
constexpr double kSamplesOfScene = 8e6;

double count_of(int level) { return std::ldexp(1.0, 2 * level); }

}  // namespace

EmissionParts::EmissionParts(const optics::Optics& optics, std::uint32_t triangle,
                             std::size_t uneven)
    : optics_(optics), triangle_(triangle) {
  if (is_uneven(optics, triangle)) {
    texels_ = optics.emission_texels(triangle);
    samples_ = kSamplesOfScene / static_cast<double>(std::max<std::size_t>(1, uneven));
    while (levels_ < kMostCuts && texels_ > kTexelsOfPart * count_of(levels_) &&
           samples_ > kSamples * kSamples * count_of(levels_ + 1)) {
      ++levels_;
    }
    most_samples_ = std::clamp(static_cast<int>(std::sqrt(samples_ / count_of(levels_))), kSamples,
                               kMostSamples);
  }
  for (int level = 0; level <= levels_; ++level) {
    means_.emplace_back(static_cast<std::size_t>(count_of(level)));
  }
  range_.resize(means_.back().size());
  measure(kWhole, 0, 0);
  find_even(kWhole, 0, 0);
  if (most_samples_ > 0) cut_on();
}

std::array<EmissionParts::Part, 4> EmissionParts::quarters_of(const Part& part) {
  const Vec2f ab = (part[0] + part[1]) * 0.5f, bc = (part[1] + part[2]) * 0.5f,
              ca = (part[2] + part[0]) * 0.5f;
  return {{{part[0], ab, ca}, {ab, part[1], bc}, {ca, bc, part[2]}, {bc, ca, ab}}};
}

EmissionParts::Measured EmissionParts::sampled(const Part& part, int side, Vec2f shift) const {
  Rgbd sum;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Rgb least{kInfinity, kInfinity, kInfinity}, most;
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const Vec2f p =
          uniform_triangle({(static_cast<float>(i) + shift.x) / static_cast<float>(side),
                            (static_cast<float>(j) + shift.y) / static_cast<float>(side)});
      const Vec2f at = part[0] + (part[1] - part[0]) * p.x + (part[2] - part[0]) * p.y;
      const Rgb value = optics_.emission(triangle_, at.x, at.y);
      least = {std::min(least.r, value.r), std::min(least.g, value.g), std::min(least.b, value.b)};
      most = {std::max(most.r, value.r), std::max(most.g, value.g), std::max(most.b, value.b)};
      sum += to_double(value);
    }
  }
  return {part, to_float(sum / static_cast<double>(side * side)), (most - least).max()};
}

EmissionParts::Measured EmissionParts::mean_of(const Part& part, int level,
                                               std::size_t index) const {
  if (most_samples_ == 0) return {part, optics_.emission(triangle_, 1.0f / 3, 1.0f / 3)};
  // Every part has another shift, lest all on a line between two texels are off alike.
  Random random(item_seed(0xe415, index));
  const float x = random.next_float();
  const Vec2f shift{x, random.next_float()};
  // A sample a texel, at least, lest a bright one is missed.
  const auto side = static_cast<int>(std::sqrt(2 * texels_ / count_of(level)) + 1);
  const int first = std::clamp(side, kSamples, most_samples_);
  Measured measured = sampled(part, first, shift);
  if (measured.range > 0 && first < most_samples_) measured = sampled(part, most_samples_, shift);
  measured.level = level;
  return measured;
}

Rgb EmissionParts::measure(const Part& part, int level, std::size_t index) {
  Rgb mean;
  if (level == levels_) {
    const Measured measured = mean_of(part, level, index);
    mean = measured.mean;
    range_[index] = measured.range;
  } else {
    const std::array<Part, 4> quarters = quarters_of(part);
    for (std::size_t k = 0; k < 4; ++k) {
      mean += measure(quarters[k], level + 1, 4 * index + k) * 0.25f;
    }
  }
  return means_[static_cast<std::size_t>(level)][index] = mean;
}

float EmissionParts::slack(int level) const {
  return kEvenShare * std::pow(kEvenGrowth, static_cast<float>(level)) * mean(0, 0).max();
}

bool EmissionParts::is_even(int level, std::size_t index) const {
  const float most = slack(level);
  const std::size_t each = std::size_t{1} << (2 * (levels_ - level));
  const Rgb own = mean(level, index);
  const auto begin = means_.back().begin() + static_cast<std::ptrdiff_t>(index * each);
  return std::all_of(begin, begin + static_cast<std::ptrdiff_t>(each), [&](const Rgb& finest) {
    const Rgb off = finest - own;
    return std::max({std::fabs(off.r), std::fabs(off.g), std::fabs(off.b)}) <= most;
  });
}

void EmissionParts::find_even(const Part& part, int level, std::size_t index) {
  if (level == levels_ || is_even(level, index)) {
    // Put together of finer ones: even.
    const float range = level == levels_ ? range_[index] : 0;
    parts_.push_back({part, mean(level, index), range, level});
    return;
  }
  const std::array<Part, 4> quarters = quarters_of(part);
  for (std::size_t k = 0; k < 4; ++k) find_even(quarters[k], level + 1, 4 * index + k);
}

void EmissionParts::cut_on() {
  const auto holds = [&](const Measured& m) {
    return static_cast<double>(m.mean.sum()) / count_of(m.level);
  };
  const double much = kMuch * static_cast<double>(mean(0, 0).sum());
  double left = std::min(kMostFurtherParts, samples_ / (most_samples_ * most_samples_));
  for (std::size_t i = 0; i < parts_.size();) {
    const Measured whole = parts_[i];
    if (left < 4 || whole.level >= levels_ + kMostFurtherCuts || holds(whole) <= much ||
        whole.range <= slack(whole.level)) {
      ++i;
      continue;
    }
    left -= 4;
    const std::array<Part, 4> quarters = quarters_of(whole.part);
    for (std::size_t k = 0; k < 4; ++k) {
      const Measured quarter = mean_of(quarters[k], whole.level + 1, item_seed(i, k));
      if (k == 0) {
        parts_[i] = quarter;
      } else {
        parts_.push_back(quarter);
      }
    }
  }
}

}  // namespace lightbatch::radiosity
