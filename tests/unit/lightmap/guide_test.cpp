#include "core/lightmap/guide.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/lightmap/dim.h"
#include "core/math/sobol.h"
#include "tests/unit/lightmap/lit_scene.h"

namespace lightbatch::lightmap {
namespace {

/// Rays of an even grid: light 1, but 400 in one cell.
GuideGrid one_bright_cell(std::size_t bright) {
  GuideGrid grid;
  grid.rays = 10 * GuideGrid::kCells;
  grid.squares.fill(10);
  grid.squares[bright] = 10 * 400 * 400;
  return grid;
}

TEST(Guide, IsEvenWithoutLight) {
  for (const Guide& guide : {Guide(), Guide(GuideGrid{})}) {
    const Guide::Place place = guide.place({0.3f, 0.7f});
    EXPECT_EQ(place.square.x, 0.3f);
    EXPECT_EQ(place.square.y, 0.7f);
    EXPECT_EQ(place.weight, 1.0f);
  }
}

// Means come out as by even points, with far less noise where little of the square counts.
TEST(Guide, KeepsMeansAndTakesNoise) {
  constexpr std::size_t kBright = 5 + 16 * 11;
  const Guide guide(one_bright_cell(kBright));
  constexpr int kPoints = 1 << 14;
  const OwenSobol2 points(7);
  double area = 0, sum = 0, squares = 0;
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    const Guide::Place place = guide.place(points.point(i));
    ASSERT_GE(place.square.x, 0.0f);
    ASSERT_LT(place.square.x, 1.0f);
    ASSERT_GE(place.square.y, 0.0f);
    ASSERT_LT(place.square.y, 1.0f);
    ASSERT_LE(place.weight, 2.51f);  // four in ten points stay even
    const bool bright = GuideGrid::cell(place.square) == kBright;
    const auto value = static_cast<double>((bright ? 400.0f : 1.0f) * place.weight);
    area += static_cast<double>(place.weight) / kPoints;
    sum += value / kPoints;
    squares += value * value / kPoints;
  }
  const double exact = (400 + 255) / 256.0;
  EXPECT_NEAR(area, 1, 0.01);
  EXPECT_NEAR(sum, exact, 0.01 * exact);
  const double even = (400.0 * 400 + 255) / 256 - exact * exact;  // variance of a point
  EXPECT_LT(squares - sum * sum, 0.1 * even);
}

// The same guide of light whose mean square is no normal float, and of light whose sums are none.
TEST(Guide, LeadsInFaintAndInStrongLight) {
  constexpr std::size_t kBright = 5 + 16 * 11;
  const Guide guide(one_bright_cell(kBright));
  const OwenSobol2 points(7);
  for (const float scale : {1e-42f, 1e32f}) {
    GuideGrid grid = one_bright_cell(kBright);
    for (float& squares : grid.squares) squares *= scale;
    const Guide other(grid);
    for (std::uint32_t i = 0; i < 64; ++i) {
      const Guide::Place place = guide.place(points.point(i)), same = other.place(points.point(i));
      // Squares of 1e-42 have three digits.
      EXPECT_NEAR(same.weight, place.weight, 2e-3f * place.weight) << scale;
    }
  }
}

// One ray that met a lamp must not draw all others there.
TEST(Guide, BelievesFewRaysLittle) {
  GuideGrid grid;
  grid.rays = 16;
  grid.squares[40] = 1e8f;
  const Guide guide(grid);
  int there = 0;
  const OwenSobol2 points(3);
  for (std::uint32_t i = 0; i < 1024; ++i) {
    if (GuideGrid::cell(guide.place(points.point(i)).square) == 40) ++there;
  }
  EXPECT_GT(there, 4);    // even: 4
  EXPECT_LT(there, 102);  // a tenth
}

/// A black room of 4 x 2 x 4 m under a sky of 1 nit, lit through a hole of 0.4 m in its ceiling.
struct HoledRoom {
  static constexpr float kHole = 0.2f, kHeight = 2;
  LitScene lit;
  HoledRoom() {
    auto& kit = lit.kit;
    const auto black = kit.material(Rgb{});
    const auto rectangle = [&](Vec3f at, Vec3f u, Vec3f v) {
      kit.quad({at, at + u, at + u + v, at + v}, black);
    };
    rectangle({-2, 0, -2}, {0, 0, 4}, {4, 0, 0});
    rectangle({-2, 0, -2}, {4, 0, 0}, {0, kHeight, 0});
    rectangle({2, 0, 2}, {-4, 0, 0}, {0, kHeight, 0});
    rectangle({-2, 0, 2}, {0, 0, -4}, {0, kHeight, 0});
    rectangle({2, 0, -2}, {0, 0, 4}, {0, kHeight, 0});
    const float wide = 2 - kHole;
    rectangle({-2, kHeight, -2}, {wide, 0, 0}, {0, 0, 4});
    rectangle({kHole, kHeight, -2}, {wide, 0, 0}, {0, 0, 4});
    rectangle({-kHole, kHeight, -2}, {2 * kHole, 0, 0}, {0, 0, wide});
    rectangle({-kHole, kHeight, kHole}, {2 * kHole, 0, 0}, {0, 0, wide});
    lit.sky = optics::Environment(Rgb::grey(1));
    lit.rays = 64;
    lit.chart(4);
    lit.solve();
  }
  /// Lux at a point of the floor.
  static double exact(const Vec3f& at) {
    constexpr int kSteps = 40;
    double sum = 0;
    for (int i = 0; i < kSteps * kSteps; ++i) {
      const double x = 2 * static_cast<double>(kHole) * ((i % kSteps + 0.5) / kSteps - 0.5);
      const double z =
          2 * static_cast<double>(kHole) * (std::floor(i / kSteps) / kSteps + 0.5 / kSteps - 0.5);
      const double dx = x - static_cast<double>(at.x), dz = z - static_cast<double>(at.z);
      const double squared = dx * dx + dz * dz + static_cast<double>(kHeight * kHeight);
      sum += static_cast<double>(kHeight * kHeight) / (squared * squared);
    }
    return sum * 4 * static_cast<double>(kHole * kHole) / (kSteps * kSteps);
  }
};

TEST(Guide, FindsTheWindow) {
  const HoledRoom room;
  const BakeInput input = room.lit.input();
  Gather gather(input, {});
  BakeCounts counts;
  double even = 0, guided = 0, all = 0;
  for (std::uint32_t t = 0; t < input.texels.texels.size(); ++t) {
    const TexelPoints points = texel_points(input.texels, input.texels.texels[t]);
    const auto at = receiver_at(input.scene, input.layout, points.point[0], 0).frame;
    if (at.normal.y < 0.9f || points.count < 16) continue;
    Gather::Scratch scratch;
    const double exact = HoledRoom::exact(at.position);
    const auto gathered = [&](int rays, std::uint32_t seed) {
      const double off =
          static_cast<double>(gather(points, rays, seed, {}, scratch, counts).irradiance.g) - exact;
      return off * off;
    };
    even += gathered(256, 3 * t);
    gathered(2048, 3 * t + 1);  // what a tile's texels learn together
    scratch.guide = Guide(scratch.learned);
    guided += gathered(256, 3 * t + 2);
    all += exact * exact;
  }
  ASSERT_GT(all, 0);
  // A hundredth of the rays finds the hole without a guide. With one, as many as five times the
  // rays would.
  EXPECT_GT(std::sqrt(even / all), 0.25);
  EXPECT_LT(guided, even / 5);
}

TEST(DimShare, GoesFromOneDownToALimit) {
  EXPECT_EQ(dim_share(3, 2, 0.6), 1);
  EXPECT_EQ(dim_share(0.1, 2, 0), 1);
  EXPECT_NEAR(dim_share(0.2, 2, 0.5), std::sqrt(0.1), 1e-12);
  EXPECT_EQ(dim_share(0, 2, 0.5), dim_share(1e-9, 2, 0.5));
  EXPECT_GT(dim_share(0, 2, 1), 1e-3);
  EXPECT_EQ(dim_share(1, 0, 1), 1);
}

}  // namespace
}  // namespace lightbatch::lightmap
