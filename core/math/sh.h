#pragma once

#include <array>
#include <cstddef>

#include "core/math/vec.h"

namespace lightbatch {

/// Real spherical harmonics of order 2 (bands 0 to 2, nine coefficients, orthonormal).
using Sh9 = std::array<float, 9>;

/// Values at a unit direction.
inline Sh9 sh_basis(const Vec3f& d) {
  return {0.28209479f,
          0.48860251f * d.y,
          0.48860251f * d.z,
          0.48860251f * d.x,
          1.09254843f * d.x * d.y,
          1.09254843f * d.y * d.z,
          0.31539157f * (3 * d.z * d.z - 1),
          1.09254843f * d.x * d.z,
          0.54627422f * (d.x * d.x - d.y * d.y)};
}

/// Bands of the clamped cosine max(0, n . w) (Ramamoorthi and Hanrahan 2001): pi, 2 pi / 3, pi / 4.
constexpr Sh9 kShCosine = {3.14159265f, 2.09439510f, 2.09439510f, 2.09439510f, 0.78539816f,
                           0.78539816f, 0.78539816f, 0.78539816f, 0.78539816f};

/// Coefficients of the clamped cosine about a unit normal.
inline Sh9 sh_cosine_lobe(const Vec3f& normal) {
  Sh9 c = sh_basis(normal);
  for (std::size_t i = 0; i < 9; ++i) c[i] *= kShCosine[i];
  return c;
}

inline float sh_dot(const Sh9& a, const Sh9& b) {
  float sum = 0;
  for (std::size_t i = 0; i < 9; ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace lightbatch
