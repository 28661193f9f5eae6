#pragma once

#include <string>
#include <vector>

#include "core/report/plot.h"

namespace lightbatch::report {

/// Maps values of an axis to [0, 1] and names its ticks.
class Scale {
 public:
  /// Covers the values, with round ends; an axis without values covers [0, 1].
  Scale(const Axis& axis, const std::vector<double>& values, int wanted_ticks);

  /// Can be shown: finite, and positive where logarithmic.
  bool shows(double value) const;
  double place(double value) const;
  const std::vector<double>& ticks() const { return ticks_; }
  std::string name(double tick) const;

 private:
  void cover_linear(double least, double most, int wanted_ticks);
  void cover_logarithmic(double least, double most, int wanted_ticks);

  Axis axis_;
  double least_ = 0;
  double most_ = 1;
  std::vector<double> ticks_;
};

std::string unit_text(Unit unit, double value);

}  // namespace lightbatch::report
