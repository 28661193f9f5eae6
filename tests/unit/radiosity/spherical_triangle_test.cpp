#include "core/radiosity/spherical_triangle.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "core/radiosity/polygon_form_factor.h"

namespace lightbatch::radiosity {
namespace {

using Corners = std::array<Vec3f, 3>;

TEST(SphericalTriangle, SolidAngleOfAnOctant) {
  const SphericalTriangle octant({0, 0, 0}, Corners{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}});
  EXPECT_NEAR(octant.solid_angle(), std::numbers::pi / 2, 1e-12);
}

TEST(SphericalTriangle, NothingIsSeenEdgeOn) {
  EXPECT_EQ(SphericalTriangle({0, 0, 0}, Corners{{{1, 0, 0}, {2, 0, 0}, {1, 1, 0}}}).solid_angle(),
            0);
  EXPECT_EQ(SphericalTriangle({0, 0, 0}, Corners{{{1, 0, 0}, {2, 0, 0}, {3, 0, 0}}}).solid_angle(),
            0);
}

TEST(SphericalTriangle, DirectionsMeetTheTriangle) {
  const Corners c{{{-1, -1, 2}, {3, 0, 2}, {0, 2, 2}}};
  const SphericalTriangle seen({0, 0, 0}, c);
  for (int i = 0; i < 32; ++i) {
    for (int j = 0; j < 32; ++j) {
      const Vec3d d = seen.direction((i + 0.5) / 32, (j + 0.5) / 32);
      EXPECT_NEAR(length(d), 1, 1e-12);
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d side = cross(to_double(c[k]), to_double(c[(k + 1) % 3]));
        EXPECT_GT(dot(d, side), -1e-9) << i << ' ' << j;
      }
    }
  }
}

/// Mean cosine over the solid angle times the solid angle is pi times the point-to-polygon form
/// factor. A 512 x 512 grid of midpoints integrates the smooth cosine to 1e-5 or better.
double cosine_integral(const Vec3d& normal, const SphericalTriangle& seen) {
  constexpr int kGrid = 512;
  double sum = 0;
  for (int i = 0; i < kGrid; ++i) {
    for (int j = 0; j < kGrid; ++j) {
      sum += std::max(0.0, dot(normal, seen.direction((i + 0.5) / kGrid, (j + 0.5) / kGrid)));
    }
  }
  return sum / (kGrid * kGrid) * seen.solid_angle();
}

TEST(SphericalTriangle, CosineIntegralIsTheFormFactor) {
  const Vec3d normal{0, 0, 1};
  // An ordinary triangle; one a million times longer than its distance, which passes close by; and
  // one far away.
  const Corners cases[] = {{{{-1, -1, 2}, {0, 2, 2}, {3, 0, 2}}},
                           {{{1e-3f, -1e3f, 1e-3f}, {1e-3f, 0, 1e3f}, {1e-3f, 1e3f, 1e-3f}}},
                           {{{50, 0, 80}, {50, 1, 80}, {51, 0, 80}}}};
  for (const Corners& c : cases) {
    const double factor = point_to_triangle({0, 0, 0}, normal, c);
    const double other = point_to_triangle({0, 0, 0}, normal, {c[0], c[2], c[1]});
    const double wanted = std::numbers::pi * std::max(factor, other);
    ASSERT_GT(wanted, 0);
    EXPECT_NEAR(cosine_integral(normal, SphericalTriangle({0, 0, 0}, c)), wanted, 2e-4 * wanted);
  }
}

}  // namespace
}  // namespace lightbatch::radiosity
