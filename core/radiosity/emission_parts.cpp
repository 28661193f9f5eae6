#include "core/radiosity/emission_parts.h"

#include <algorithm>
#include <cmath>

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
/// Samples of the finest parts, each way; of uneven ones up to so many, as the scene's allow.
constexpr int kSamples = 8, kMostSamples = 64;
constexpr double kSamplesOfScene = 8e6;

double count_of(int level) { return std::ldexp(1.0, 2 * level); }

}  // namespace

EmissionParts::EmissionParts(const optics::Optics& optics, std::uint32_t triangle,
                             std::size_t uneven)
    : optics_(optics), triangle_(triangle) {
  if (is_uneven(optics, triangle)) {
    const double texels = optics.emission_texels(triangle);
    const double samples = kSamplesOfScene / static_cast<double>(std::max<std::size_t>(1, uneven));
    while (levels_ < kMostCuts && texels > kTexelsOfPart * count_of(levels_) &&
           samples > kSamples * kSamples * count_of(levels_ + 1)) {
      ++levels_;
    }
    most_samples_ = std::clamp(static_cast<int>(std::sqrt(samples / count_of(levels_))), kSamples,
                               kMostSamples);
  }
  for (int level = 0; level <= levels_; ++level) {
    means_.emplace_back(static_cast<std::size_t>(count_of(level)));
  }
  measure(kWhole, 0, 0);
}

std::array<EmissionParts::Part, 4> EmissionParts::quarters_of(const Part& part) {
  const Vec2f ab = (part[0] + part[1]) * 0.5f, bc = (part[1] + part[2]) * 0.5f,
              ca = (part[2] + part[0]) * 0.5f;
  return {{{part[0], ab, ca}, {ab, part[1], bc}, {ca, bc, part[2]}, {bc, ca, ab}}};
}

Rgb EmissionParts::sampled(const Part& part, int side, Vec2f shift, bool& even) const {
  Rgbd sum;
  Rgb first;
  even = true;
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const Vec2f p =
          uniform_triangle({(static_cast<float>(i) + shift.x) / static_cast<float>(side),
                            (static_cast<float>(j) + shift.y) / static_cast<float>(side)});
      const Vec2f at = part[0] + (part[1] - part[0]) * p.x + (part[2] - part[0]) * p.y;
      const Rgb value = optics_.emission(triangle_, at.x, at.y);
      if (i == 0 && j == 0) first = value;
      even = even && value == first;
      sum += to_double(value);
    }
  }
  return to_float(sum / static_cast<double>(side * side));
}

Rgb EmissionParts::mean_of(const Part& part, std::size_t index) const {
  if (most_samples_ == 0) return optics_.emission(triangle_, 1.0f / 3, 1.0f / 3);
  // Every part has another shift, lest all on a line between two texels are off alike.
  Random random(item_seed(0xe415, index));
  const float x = random.next_float();
  const Vec2f shift{x, random.next_float()};
  bool even = true;
  const Rgb mean = sampled(part, kSamples, shift, even);
  return even || most_samples_ == kSamples ? mean : sampled(part, most_samples_, shift, even);
}

Rgb EmissionParts::measure(const Part& part, int level, std::size_t index) {
  Rgb mean;
  if (level == levels_) {
    mean = mean_of(part, index);
  } else {
    const std::array<Part, 4> quarters = quarters_of(part);
    for (std::size_t k = 0; k < 4; ++k) {
      mean += measure(quarters[k], level + 1, 4 * index + k) * 0.25f;
    }
  }
  return means_[static_cast<std::size_t>(level)][index] = mean;
}

bool EmissionParts::is_even(int level, std::size_t index) const {
  const float slack =
      kEvenShare * std::pow(kEvenGrowth, static_cast<float>(level)) * mean(0, 0).max();
  const std::size_t each = std::size_t{1} << (2 * (levels_ - level));
  const Rgb own = mean(level, index);
  const auto begin = means_.back().begin() + static_cast<std::ptrdiff_t>(index * each);
  return std::all_of(begin, begin + static_cast<std::ptrdiff_t>(each), [&](const Rgb& finest) {
    const Rgb off = finest - own;
    return std::max({std::fabs(off.r), std::fabs(off.g), std::fabs(off.b)}) <= slack;
  });
}

}  // namespace lightbatch::radiosity
