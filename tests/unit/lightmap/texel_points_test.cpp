#include "core/lightmap/texel_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/lightmap/lamp_cells.h"
#include "tests/unit/lightmap/lit_scene.h"

namespace lightbatch::lightmap {
namespace {

constexpr double kTexel = 0.1;  // metres
constexpr Vec2f kMiddle{0.5f, 0.5f};

/// A floor of 1 x 1 m at height 0.
struct Floor {
  LitScene lit;
  Floor() {
    lit.kit.quad({Vec3f{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}},
                 lit.kit.material(Rgb::grey(0.5f)));
    lit.chart(1 / kTexel);
    lit.kit.finish();
  }
  Receivers receivers() { return {lit.kit.scene(), lit.layout, 1e-4f}; }
};

TEST(Receivers, EqualOnePointAtATime) {
  Floor floor;
  Receivers receivers = floor.receivers();
  for (const atlas::Texel& texel : floor.lit.texels.texels) {
    const TexelPoints points = texel_points(floor.lit.texels, texel);
    for (std::uint32_t i = 0; i < points.count; ++i) {
      const auto all = receivers(points.point[i], kMiddle);
      const auto one = receiver_at(floor.lit.kit.scene(), floor.lit.layout, points.point[i], 1e-4f);
      ASSERT_EQ(all.triangle, one.triangle);
      ASSERT_LT(length(all.frame.position - one.frame.position), 1e-6f);
      ASSERT_EQ(all.frame.normal, (Vec3f{0, 1, 0}));
      ASSERT_GT(all.frame.origin.y, 0.0f);
    }
  }
}

TEST(Receivers, MovedPointsStayOnTheirTriangleAndInTheirShare) {
  Floor floor;
  Receivers receivers = floor.receivers();
  const auto quarter = static_cast<float>(kTexel / 8 * 1.01);
  for (const atlas::Texel& texel : floor.lit.texels.texels) {
    const TexelPoints points = texel_points(floor.lit.texels, texel);
    for (std::uint32_t i = 0; i < points.count; ++i) {
      const Vec3f about = receivers(points.point[i], kMiddle).frame.position;
      for (const Vec2f by :
           {Vec2f{0, 0}, Vec2f{0.99f, 0}, Vec2f{0.2f, 0.9f}, Vec2f{0.99f, 0.99f}}) {
        const auto moved = receivers(points.point[i], by);
        ASSERT_EQ(moved.triangle, points.point[i].triangle);
        const Vec3f off = moved.frame.position - about;
        ASSERT_LE(std::max(std::fabs(off.x), std::fabs(off.z)), quarter);
        for (const float v : {moved.frame.position.x, moved.frame.position.z}) {
          ASSERT_GE(v, -1e-5f);
          ASSERT_LE(v, 1 + 1e-5f);
        }
      }
    }
  }
}

/// Lux that the cells of the texel's sixteenths tell.
double mean_of(Floor& floor, const radiosity::PunctualLight& light, const atlas::Texel& texel,
               double allowed) {
  std::vector<LampCell> cells;
  double sum = 0;
  const TexelPoints points = texel_points(floor.lit.texels, texel);
  for (std::uint32_t i = 0; i < points.count; ++i) {
    cut_for_lamp(light, floor.lit.kit.scene(), floor.lit.layout, points.point[i], allowed, cells);
    for (const LampCell& cell : cells) sum += static_cast<double>(cell.light.r);
  }
  return sum / points.count;
}

/// Over the whole floor; texels at its edge are covered in part.
double mean_of(Floor& floor, const radiosity::PunctualLight& light, double allowed) {
  double sum = 0, points_in_all = 0;
  for (const atlas::Texel& texel : floor.lit.texels.texels) {
    const auto points = static_cast<double>(texel_points(floor.lit.texels, texel).count);
    sum += points * mean_of(floor, light, texel, allowed);
    points_in_all += points;
  }
  return sum / points_in_all;
}

/// A metre above the floor, straight down, its cone left open.
radiosity::PunctualLight spot_above(float candela) {
  radiosity::PunctualLight light;
  light.kind = scene::LightKind::kSpot;
  light.position = {0.487f, 1, 0.513f};
  light.direction = {0, -1, 0};
  light.intensity = Rgb::grey(candela);
  return light;
}

// Half of what a lamp sends out falls on a floor right below it.
TEST(LampCells, HoldTheFluxOfALampOneMillimetreAbove) {
  Floor floor;
  radiosity::PunctualLight light;
  light.position = {0.487f, 0.001f, 0.513f};
  light.intensity = Rgb::grey(100);
  const double exact = 2 * kPiDouble * 100;
  EXPECT_NEAR(mean_of(floor, light, 1), exact, 0.005 * exact);
  EXPECT_TRUE(varies_within(light, {0.5f, 0, 0.5f}, 0.07f));
  EXPECT_FALSE(varies_within(light, {0.9f, 0, 0.9f}, 0.07f));
}

// A cone whose foot is a tenth of a texel wide; the flux of the squared ramp of dips is a third of
// that of the cone.
TEST(LampCells, HoldTheFluxOfAThinCone) {
  Floor floor;
  radiosity::PunctualLight light = spot_above(1e6f);
  light.dip_inner = 0;
  light.dip_outer = static_cast<float>(1 - std::cos(0.005));
  const double exact = 2 * kPiDouble * static_cast<double>(light.dip_outer) * 1e6 / 3;
  EXPECT_NEAR(mean_of(floor, light, 1), exact, 0.01 * exact);
  light.dip_inner = light.dip_outer;
  EXPECT_NEAR(mean_of(floor, light, 1), 3 * exact, 0.03 * exact);
  EXPECT_TRUE(varies_within(light, {0.45f, 0, 0.55f}, 0.07f));
  EXPECT_FALSE(varies_within(light, {0.2f, 0, 0.55f}, 0.07f));
}

// A cone without a ramp, whose edge runs through the texels of a ring: each to the allowed error.
TEST(LampCells, FollowTheEdgeOfASharpCone) {
  Floor floor;
  radiosity::PunctualLight light = spot_above(1000);
  light.dip_inner = light.dip_outer = static_cast<float>(1 - std::cos(0.3));
  Receivers receivers = floor.receivers();
  constexpr int kFine = 64;  // points of a sixteenth, each way
  for (const double allowed : {20.0, 2.0}) {
    double squares = 0, most = 0, edges = 0;
    for (const atlas::Texel& texel : floor.lit.texels.texels) {
      const TexelPoints points = texel_points(floor.lit.texels, texel);
      double exact = 0, lit = 0;
      for (std::uint32_t i = 0; i < points.count; ++i) {
        for (int k = 0; k < kFine * kFine; ++k) {
          const Vec2f at{(static_cast<float>(k % kFine) + 0.5f) / kFine,
                         (static_cast<float>(k / kFine) + 0.5f) / kFine};
          const auto frame = receivers(points.point[i], at).frame;
          const double lux = static_cast<double>(light.irradiance(frame.position, frame.normal).r);
          exact += lux / (kFine * kFine * static_cast<double>(points.count));
          lit += lux > 0 ? 1 : 0;
        }
      }
      if (lit == 0 || lit == kFine * kFine * points.count) continue;
      const double off = mean_of(floor, light, texel, allowed) - exact;
      squares += off * off;
      most = std::max(most, std::fabs(off));
      edges += 1;
    }
    EXPECT_GT(edges, 15);
    EXPECT_LT(std::sqrt(squares / edges), allowed);
    EXPECT_LT(most, 3 * allowed);  // three standard errors
  }
}

}  // namespace
}  // namespace lightbatch::lightmap
