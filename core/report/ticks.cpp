#include "core/report/ticks.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/report/text.h"

namespace lightbatch::report {

Scale::Scale(const Axis& axis, const std::vector<double>& values, int wanted_ticks) : axis_(axis) {
  double least = 0, most = 0;
  bool any = false;
  for (const double value : values) {
    if (!shows(value)) continue;
    least = any ? std::min(least, value) : value;
    most = any ? std::max(most, value) : value;
    any = true;
  }
  if (!any) {
    least = axis.logarithmic ? 0.1 : 0;
    most = 1;
  }
  if (axis.logarithmic) {
    cover_logarithmic(least, most, wanted_ticks);
  } else {
    cover_linear(axis.from_zero ? std::min(0.0, least) : least, most, wanted_ticks);
  }
}

bool Scale::shows(double value) const {
  // Far ends are kept off so that widths and ratios stay finite.
  return std::isfinite(value) && std::abs(value) < 1e100 && (!axis_.logarithmic || value > 1e-100);
}

void Scale::cover_linear(double least, double most, int wanted_ticks) {
  if (most - least < 1e-9 * std::max(std::abs(least), std::abs(most)) || most <= least) {
    const double around = std::abs(most) > 0 ? 0.5 * std::abs(most) : 0.5;
    most += around;
    least -= axis_.from_zero && least >= 0 ? 0 : around;
  }
  // Steps of 1, 2 or 5 times a power of ten.
  const double rough = (most - least) / wanted_ticks;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double ratio = rough / power;
  const double step = power * (ratio <= 1 ? 1 : ratio <= 2 ? 2 : ratio <= 5 ? 5 : 10);
  const double first = std::floor(least / step + 1e-9), last = std::ceil(most / step - 1e-9);
  least_ = first * step;
  most_ = last * step;
  for (double i = first; i <= last + 0.5 && ticks_.size() < 100; ++i) ticks_.push_back(i * step);
}

void Scale::cover_logarithmic(double least, double most, int wanted_ticks) {
  static constexpr std::array kPattern = {1.0, 2.0, 5.0};
  const auto round_number = [](int k) {  // 1, 2, 5, 10, 20...
    const int decade = k >= 0 ? k / 3 : -((2 - k) / 3);
    return kPattern[static_cast<std::size_t>(k - 3 * decade)] * std::pow(10.0, decade);
  };
  int first = static_cast<int>(std::floor(3 * std::log10(least))) - 1;
  while (round_number(first + 1) <= least * (1 + 1e-9)) ++first;
  int last = first + 1;
  while (round_number(last) < most * (1 - 1e-9)) ++last;
  least_ = round_number(first);
  most_ = round_number(last);
  // Every number of 1-2-5 when they fit, else powers of ten, of every few decades.
  const bool dense = last - first <= wanted_ticks + 1;
  const int stride = 3 * std::max(1, (last - first) / 3 / std::max(1, wanted_ticks) + 1);
  for (int k = first; k <= last; ++k) {
    const int wrapped = ((k % stride) + stride) % stride;
    if (dense || wrapped == 0 || ((last - first) <= 3 * wanted_ticks && k % 3 == 0)) {
      ticks_.push_back(round_number(k));
    }
  }
}

double Scale::place(double value) const {
  if (axis_.logarithmic) return std::log(value / least_) / std::log(most_ / least_);
  return (value - least_) / (most_ - least_);
}

std::string Scale::name(double tick) const {
  const double zero = 1e-9 * std::max(std::abs(least_), std::abs(most_));
  return unit_text(axis_.unit, std::abs(tick) < zero ? 0 : tick);
}

namespace {

/// Ticks are round numbers: "500 ms", "2 s", "1,000 s".
std::string tick_seconds(double value) {
  return std::abs(value) < 1 ? seconds_text(value) : count_text(value) + " s";
}

}  // namespace

std::string unit_text(Unit unit, double value) {
  switch (unit) {
    case Unit::kPercent:
      return percent_text(value);
    case Unit::kSeconds:
      return value == 0 ? "0" : value < 10'000 ? tick_seconds(value) : seconds_text(value);
    case Unit::kBytes:
      return bytes_text(value);
    case Unit::kNumber:
      break;
  }
  if (std::abs(value) >= 1e9) return significant(value / 1e9, 3) + "G";
  if (std::abs(value) >= 1e6) return significant(value / 1e6, 3) + "M";
  if (std::abs(value) >= 1e4) return significant(value / 1e3, 3) + "k";
  return significant(value, 4);
}

}  // namespace lightbatch::report
