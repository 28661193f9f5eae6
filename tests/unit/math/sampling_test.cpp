#include "core/math/sampling.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "core/base/random.h"
#include "core/math/sobol.h"

namespace lightbatch {
namespace {

// A (0, 2)-sequence in base 2: every elementary interval of area 2^-k holds one of 2^k points.
TEST(OwenSobol, FirstTwoDimensionsAreStratifiedInEveryElementaryInterval) {
  for (std::uint32_t seed : {0u, 1u, 77u, 0xdeadbeefu}) {
    const OwenSobol2 points(seed);
    for (unsigned k = 0; k <= 10; ++k) {
      for (unsigned split = 0; split <= k; ++split) {
        std::set<std::pair<int, int>> cells;
        for (std::uint32_t i = 0; i < (1u << k); ++i) {
          const Vec2f p = points.point(i);
          ASSERT_TRUE(p.x >= 0 && p.x < 1 && p.y >= 0 && p.y < 1);
          cells.insert({static_cast<int>(std::ldexp(p.x, static_cast<int>(split))),
                        static_cast<int>(std::ldexp(p.y, static_cast<int>(k - split)))});
        }
        ASSERT_EQ(cells.size(), std::size_t{1} << k) << "seed " << seed << " split " << split;
      }
    }
  }
}

TEST(OwenSobol, EachOfEightDimensionsIsStratified) {
  const OwenSobol8 points(5);
  for (std::size_t d = 0; d < 8; ++d) {
    for (std::uint32_t start : {0u, 4096u, 1u << 20}) {
      std::set<int> slots;
      for (std::uint32_t i = 0; i < 4096; ++i) {
        slots.insert(static_cast<int>(points.coordinate(start + i, d) * 4096));
      }
      EXPECT_EQ(slots.size(), 4096u) << "dimension " << d;
    }
  }
}

// Unscrambled points of Joe and Kuo's own listing (three dimensions; theirs is in Gray-code order,
// so their rows 1, 2, 4, 7 are points 1, 3, 6, 4 here).
TEST(OwenSobol, BaseSequenceIsJoeKuo) {
  struct Expected {
    std::uint32_t index;
    std::array<double, 3> point;
  };
  const std::array<Expected, 4> listing = {{{1, {0.5, 0.5, 0.5}},
                                            {3, {0.75, 0.25, 0.25}},
                                            {6, {0.375, 0.375, 0.625}},
                                            {4, {0.125, 0.625, 0.375}}}};
  for (const Expected& e : listing) {
    for (std::size_t d = 0; d < 3; ++d) {
      const double value =
          static_cast<double>(sobol::reverse_bits(sobol::reversed_point(d, e.index))) * 0x1p-32;
      EXPECT_EQ(value, e.point[d]) << "dimension " << d << " point " << e.index;
    }
  }
}

// Mean over seeds of a fixed point is uniform; integrals of a smooth function fall faster than
// random ones (N^-1 or better against N^-0.5).
TEST(OwenSobol, ScramblesAreUnbiasedAndConvergeFast) {
  double mean = 0, error = 0;
  const int seeds = 2000;
  for (int s = 0; s < seeds; ++s) {
    const OwenSobol2 points(static_cast<std::uint32_t>(s));
    mean += static_cast<double>(points.point(3).x) / seeds;
    double integral = 0;
    for (std::uint32_t i = 0; i < 256; ++i) {
      const Vec2f p = points.point(i);
      integral += static_cast<double>(p.x * p.x * p.y) / 256;
    }
    error += (integral - 1.0 / 6) * (integral - 1.0 / 6) / seeds;
  }
  EXPECT_NEAR(mean, 0.5, 4 * 0.29 / std::sqrt(seeds));
  // Random sampling has a standard deviation of 0.0123 at 256 points (variance 1/15 - 1/36).
  EXPECT_LT(std::sqrt(error), 0.0123 / 15);
}

TEST(Sampling, FrameIsOrthonormalAndRightHandedEverywhere) {
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    Vec3f n{random.next_float() - 0.5f, random.next_float() - 0.5f, random.next_float() - 0.5f};
    if (i == 0) n = {0, 0, -1};
    if (i == 1) n = {0, 0, 1};
    if (i == 2) n = {1e-20f, 0, -1};
    n = normalized(n);
    const Frame f = Frame::about(n);
    EXPECT_NEAR(length(f.x), 1, 1e-5);
    EXPECT_NEAR(length(f.y), 1, 1e-5);
    EXPECT_NEAR(dot(f.x, f.y), 0, 1e-5);
    EXPECT_NEAR(dot(f.x, f.z), 0, 1e-5);
    EXPECT_NEAR(dot(cross(f.x, f.y), f.z), 1, 1e-5);
  }
}

TEST(Sampling, CosineHemisphereHasItsMoments) {
  const OwenSobol2 points(9);
  const int n = 1 << 16;
  double z = 0, zz = 0, x = 0, xx = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    const Vec3f d = cosine_hemisphere(points.point(i));
    EXPECT_NEAR(length(d), 1, 2e-6);
    EXPECT_GT(d.z, 0);
    z += static_cast<double>(d.z) / n;
    zz += static_cast<double>(d.z * d.z) / n;
    x += static_cast<double>(d.x) / n;
    xx += static_cast<double>(d.x * d.x) / n;
  }
  EXPECT_NEAR(z, 2.0 / 3, 1e-4);
  EXPECT_NEAR(zz, 0.5, 1e-4);
  EXPECT_NEAR(x, 0, 1e-4);
  EXPECT_NEAR(xx, 0.25, 1e-4);
}

TEST(Sampling, TrianglePointsAreUniform) {
  const OwenSobol2 points(2);
  const int n = 1 << 14;
  double u = 0, v = 0, uu = 0, uv = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    const Vec2f p = uniform_triangle(points.point(i));
    ASSERT_TRUE(p.x >= 0 && p.y >= 0 && p.x + p.y <= 1);
    u += static_cast<double>(p.x) / n;
    v += static_cast<double>(p.y) / n;
    uu += static_cast<double>(p.x * p.x) / n;
    uv += static_cast<double>(p.x * p.y) / n;
  }
  EXPECT_NEAR(u, 1.0 / 3, 1e-3);
  EXPECT_NEAR(v, 1.0 / 3, 1e-3);
  EXPECT_NEAR(uu, 1.0 / 6, 1e-3);
  EXPECT_NEAR(uv, 1.0 / 12, 1e-3);
}

TEST(Sampling, HeuristicsPartitionUnity) {
  for (double a : {0.0, 1e-30, 0.3, 7.0, 1e30}) {
    for (double b : {1e-30, 0.2, 5.0}) {
      EXPECT_NEAR(balance_heuristic(3, a, 2, b) + balance_heuristic(2, b, 3, a), 1, 1e-12);
      EXPECT_NEAR(power_heuristic(3, a, 2, b) + power_heuristic(2, b, 3, a), 1, 1e-12);
    }
  }
}

TEST(DiscreteSampler, PicksInProportionAndNeverAZero) {
  const std::vector<double> weights = {0, 1, 0, 0, 3, 1e-3, 0, 6, 0};
  const DiscreteSampler sampler(weights);
  std::vector<int> counts(weights.size());
  const int n = 200000;
  for (int i = 0; i < n; ++i) {
    const double random = (i + 0.5) / n;
    const auto pick = sampler.pick(random);
    ++counts[pick.index];
    EXPECT_GE(pick.rest, 0);
    EXPECT_LT(pick.rest, 1);
  }
  for (std::size_t i = 0; i < weights.size(); ++i) {
    EXPECT_NEAR(counts[i], n * weights[i] / sampler.total(), 1.5) << i;
    EXPECT_NEAR(sampler.probability(i), weights[i] / sampler.total(), 1e-14);
  }
  EXPECT_EQ(sampler.pick(0).index, 1u);
  EXPECT_EQ(sampler.pick(0x1.fffffffffffffp-1).index, 7u);
  EXPECT_TRUE(DiscreteSampler(std::vector<double>{0, 0}).is_empty());
  EXPECT_TRUE(DiscreteSampler().is_empty());
}

}  // namespace
}  // namespace lightbatch
