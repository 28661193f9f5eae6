#include "core/atlas/texel_part.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace lightbatch::atlas {
namespace {

constexpr int kSide = 64;

/// Points of the part for the middles of a grid, by weights of corners 1 and 2.
std::vector<Vec2f> points_of(const TexelPart& part) {
  std::vector<Vec2f> points;
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      points.push_back(part.at(
          {(static_cast<float>(i) + 0.5f) / kSide, (static_cast<float>(j) + 0.5f) / kSide}));
    }
  }
  return points;
}

Vec2d mean_of(const std::vector<Vec2f>& points) {
  Vec2d sum;
  for (const Vec2f& p : points) {
    sum = sum + Vec2d{static_cast<double>(p.x), static_cast<double>(p.y)};
  }
  return sum * (1.0 / static_cast<double>(points.size()));
}

/// Share of points with a weight of corner 0 above one half.
double share_at_corner(const std::vector<Vec2f>& points) {
  double count = 0;
  for (const Vec2f& p : points) count += p.x + p.y < 0.5f ? 1 : 0;
  return count / static_cast<double>(points.size());
}

TEST(TexelPart, OfATriangleThatCollapsedToAPointIsTheWholeTriangle) {
  const auto points = points_of(TexelPart({{{4096, 4096}, {4096, 4096}, {4096, 4096}}}, 2, 2));
  EXPECT_NEAR(mean_of(points).x, 1.0 / 3, 1e-3);
  EXPECT_NEAR(mean_of(points).y, 1.0 / 3, 1e-3);
  EXPECT_NEAR(share_at_corner(points), 0.25, 0.01);
  for (const Vec2f& p : points) {
    ASSERT_GE(std::min(p.x, p.y), -1e-6f);
    ASSERT_LE(p.x + p.y, 1 + 1e-6f);
  }
}

// Corners 0 and 1 at one end, corner 2 four texels on: the second texel holds the weights of
// corner 2 from 1/4 to 1/2, whose surface is (9 - 4) / 16.
TEST(TexelPart, OfALineIsTheSectionInTheTexel) {
  const GridTriangle line{{{0, 2048}, {0, 2048}, {4 * 2048, 2048}}};
  const auto points = points_of(TexelPart(line, 1, 1));
  double below = 0;
  for (const Vec2f& p : points) {
    ASSERT_GE(p.y, 0.25f - 1e-6f);
    ASSERT_LE(p.y, 0.5f + 1e-6f);
    ASSERT_GE(p.x, -1e-6f);
    ASSERT_LE(p.x + p.y, 1 + 1e-6f);
    below += p.y < 0.375f ? 1 : 0;
  }
  const double exact = (9.0 / 16 - 25.0 / 64) / (9.0 / 16 - 4.0 / 16);
  EXPECT_NEAR(below / static_cast<double>(points.size()), exact, 0.01);
}

TEST(TexelPart, OfATriangleOverSeveralTexelsStaysInItsTexel) {
  const GridTriangle triangle{{{100, 200}, {3 * 2048, 900}, {700, 4 * 2048}}};
  for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
    for (const Vec2f& p : points_of(TexelPart(triangle, x, y))) {
      const auto at = [&](double a, double b, double c) {
        const auto u = static_cast<double>(p.x), v = static_cast<double>(p.y);
        return (a * (1 - u - v) + b * u + c * v) / kUnits;
      };
      const double px = at(triangle[0].x, triangle[1].x, triangle[2].x);
      const double py = at(triangle[0].y, triangle[1].y, triangle[2].y);
      ASSERT_GE(px, x - 1e-3);
      ASSERT_LE(px, x + 1 + 1e-3);
      ASSERT_GE(py, y - 1e-3);
      ASSERT_LE(py, y + 1 + 1e-3);
    }
  }
}

}  // namespace
}  // namespace lightbatch::atlas
