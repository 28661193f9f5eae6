#pragma once

#include <cmath>

#include "core/base/parallel.h"
#include "core/math/rgb.h"
#include "core/radiosity/elements.h"

namespace lightbatch::radiosity {

/// Sum over the elements of covered area times value_of(element).
template <typename ValueOf>
Rgbd area_sum(const Elements& elements, ValueOf value_of) {
  return deterministic_reduce(
      elements.count(), 4096, Rgbd{},
      [&](std::size_t begin, std::size_t end) {
        Rgbd sum;
        for (std::size_t i = begin; i < end; ++i) {
          const auto e = static_cast<ElementId>(i);
          sum += value_of(e) * static_cast<double>(elements.covered_area(e));
        }
        return sum;
      },
      [](const Rgbd& a, const Rgbd& b) { return a + b; });
}

/// a / b per channel, 0 where b is nothing.
inline Rgbd divide(const Rgbd& a, const Rgbd& b) {
  const auto ratio = [](double x, double y) { return std::fabs(y) > 1e-300 ? x / y : 0.0; };
  return {ratio(a.r, b.r), ratio(a.g, b.g), ratio(a.b, b.b)};
}

}  // namespace lightbatch::radiosity
