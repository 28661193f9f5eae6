#pragma once

#include <algorithm>
#include <cmath>

#include "core/math/sampling.h"
#include "core/math/vec.h"

namespace lightbatch::optics {

/// Geometry of equirectangular maps, as Environment reads them: row 0 at the zenith (+Y), u around.

/// Height y on the unit sphere of the upper border of row `row` of `rows`.
inline double border_height(int row, int rows) {
  return std::cos(kPiDouble * static_cast<double>(row) / static_cast<double>(rows));
}

/// Of `columns` pixels beside each other, from the upper border of one row to that of another, sr.
inline double solid_angle(int top, int bottom, int columns, int width, int height) {
  return (border_height(top, height) - border_height(bottom, height)) * 2 * kPiDouble *
         static_cast<double>(columns) / static_cast<double>(width);
}

/// Unit; u in [0, 1], height on the unit sphere.
inline Vec3d direction_at(double u, double height) {
  const double angle = (u - 0.5) * 2 * kPiDouble;
  const double across = std::sqrt(std::max(0.0, 1 - height * height));
  return {across * std::cos(angle), height, across * std::sin(angle)};
}

}  // namespace lightbatch::optics
