#include "core/lightmap/emitter_texel.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "core/lightmap/punctual_texel.h"
#include "tests/unit/lightmap/lit_scene.h"

namespace lightbatch::lightmap {
namespace {

constexpr SourceState::State kDark = SourceState::kDark, kLit = SourceState::kLit,
                             kMixed = SourceState::kMixed;

TEST(EmitterTexel, ASourceIsDoubtfulWhereNeighboursDiffer) {
  const std::vector<SourceState> own{{1, kDark}, {4, kLit}, {6, kDark}, {9, kMixed}};
  const std::vector<SourceState> near{{2, kLit}, {4, kDark}, {9, kLit}};
  const std::vector<SourceState> other{{1, kDark}, {6, kMixed}};
  const std::span<const SourceState> around[] = {near, {}, other};
  const auto states = doubtful_states(own, around);
  ASSERT_EQ(states.size(), 4u);
  const std::uint32_t expected[] = {kDark, kMixed, kMixed, kMixed};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(states[i].state, expected[i]) << i;
}

/// Eight rooms in a row, each under a panel of its own, black walls between; a table in each. Light
/// of the neighbours' panels comes to no texel.
struct Rooms {
  static constexpr int kRooms = 8;
  LitScene lit;
  bool points;

  explicit Rooms(bool point_lights) : points(point_lights) {
    auto& kit = lit.kit;
    const std::uint32_t wall = kit.material(Rgb{});
    const std::uint32_t panel = kit.material(Rgb{}, Rgb::grey(1000));
    for (int k = 0; k < kRooms; ++k) {
      const auto x = static_cast<float>(4 * k);
      kit.box({x, 0, 0}, {x + 3.9f, 3, 4}, wall);
      kit.box({x + 1, 0.7f, 1}, {x + 2, 0.75f, 2}, wall, false);
      if (!points) {
        kit.quad({Vec3f{x + 1, 2.9f, 2},
                  {x + 1.6f, 2.9f, 2},
                  {x + 1.6f, 2.9f, 2.6f},
                  {x + 1, 2.9f, 2.6f}},
                 panel);
        continue;
      }
      for (int i = 0; i < 4; ++i) {
        scene::Light light;
        light.position = {static_cast<double>(x) + 0.5 + 0.8 * i, 2.5, 2.2};
        light.intensity = Rgb::grey(50);
        kit.scene().lights.push_back(light);
      }
    }
    lit.chart(4);
    lit.solve();
  }

  std::vector<Rgb> bake(double error, BakeCounts& counts) const {
    GatherSettings settings;
    settings.direct_error = error;
    radiosity::GroupedLight none;
    const DimShares dim(lit.input(), settings);
    return bake_direct(lit.input(), settings, dim, none, counts, Progress{});
  }

  /// Mean over the texel by many random points, every light asked at each.
  double truth(std::uint32_t t, const radiosity::DirectLight& direct) const {
    const TexelPoints grid = texel_points(lit.texels, lit.texels.texels[t]);
    Random random(t);
    double sum = 0;
    constexpr int kPoints = 2048;
    radiosity::RayCounts counts;
    for (int k = 0; k < kPoints; ++k) {
      const Vec2f by{random.next_float(), random.next_float()};
      const auto at = receiver_at(
          lit.kit.scene(), lit.layout,
          moved_within(lit.layout, grid.point[random.below(grid.count)], by), direct.lift());
      const double pick = random.next_double();
      sum += static_cast<double>(
          direct.sampled_emitters(at, 0, pick, {random.next_float(), random.next_float()}, counts)
              .irradiance.g);
    }
    return sum / kPoints;
  }
};

// A strip of light 15 mm wide, 6 mm above texels of half a metre: all that it sends arrives. From
// the sixteenths' middles alone, 120 mm apart, it is a matter of luck (0.73 to 0.89).
TEST(EmitterTexel, ANarrowStripCloseToLargeTexelsIsFound) {
  for (const float x : {0.11f, 0.2f, 0.26f}) {
    LitScene lit;
    auto& kit = lit.kit;
    const std::uint32_t black = kit.material(Rgb{});
    kit.quad({Vec3f{-2, 0, -2}, {-2, 0, 2}, {2, 0, 2}, {2, 0, -2}}, black);
    const float y = 0.006f;
    kit.quad({Vec3f{x, y, -1.5f}, {x + 0.015f, y, -1.5f}, {x + 0.015f, y, 1.5f}, {x, y, 1.5f}},
             kit.material(Rgb{}, Rgb::grey(1000)));
    lit.chart(2);
    lit.solve();
    const BakeInput input = lit.input();
    GatherSettings settings;
    settings.direct_error = 0.03;
    radiosity::GroupedLight none;
    const DimShares dim(input, settings);
    BakeCounts counts;
    const auto direct = bake_direct(input, settings, dim, none, counts, Progress{});
    double arrives = 0;
    for (std::size_t t = 0; t < direct.size(); ++t) {
      arrives += static_cast<double>(direct[t].g) * lit.texels.surface_of(lit.texels.texels[t]);
    }
    EXPECT_NEAR(arrives / (static_cast<double>(kPi) * 1000 * 0.015 * 3), 1, 0.03) << x;
  }
}

// relRMSE of direct light over every 61st texel; the noise of the truth is 1 % of a texel and 0.4 %
// of the mean. Errors are asked for at the edges of shadows alone, so that the whole stays well
// below them.
TEST(EmitterTexel, LampsOfOtherRoomsBringNeitherErrorNorNoise) {
  for (const bool points : {false, true}) {
    const Rooms rooms(points);
    const BakeInput input = rooms.lit.input();
    ASSERT_TRUE(input.direct.sources().punctual().empty());
    BakeCounts counts;
    const std::vector<Rgb> direct = rooms.bake(0.03, counts);
    double squares = 0, mean = 0, bias = 0;
    int used = 0;
    for (std::uint32_t t = 0; t < direct.size(); t += 61) {
      const double want = rooms.truth(t, input.direct);
      const double off = static_cast<double>(direct[t].g) - want;
      squares += off * off;
      bias += off;
      mean += want;
      ++used;
    }
    ASSERT_GT(used, 60);
    EXPECT_LT(std::sqrt(squares / used) / (mean / used), 0.03) << points;
    EXPECT_LT(std::fabs(bias / mean), 0.012) << points;
    // Sixteen rays to each of six lamps that are seen in part, were they seen so everywhere.
    EXPECT_EQ(points ? counts.rays.emitter_shadow : counts.rays.punctual_shadow, 0u);
    EXPECT_LT(static_cast<double>(counts.rays.cast()) / static_cast<double>(direct.size()), 96)
        << points;
  }
}

// A lamp 0.2 m above a floor with texels of 0.5 m: the light of a texel is far from even.
TEST(EmitterTexel, LightCloseToASurfaceIsAveragedOverTheTexel) {
  for (const int lamps : {1, 20}) {
    LitScene lit;
    const std::uint32_t floor = lit.kit.material(Rgb::grey(0.2f));
    lit.kit.quad({Vec3f{-3, 0, 3}, {3, 0, 3}, {3, 0, -3}, {-3, 0, -3}}, floor);
    for (int k = 0; k < lamps; ++k) {
      scene::Light light;
      light.position = {1.13 + 0.001 * k, 0.2, 0.67};
      light.intensity = Rgb::grey(static_cast<float>(100.0 / lamps));
      lit.kit.scene().lights.push_back(light);
    }
    lit.chart(2);
    lit.solve();
    const BakeInput input = lit.input();
    EXPECT_EQ(input.direct.sources().emitters().empty(), lamps == 1);
    GatherSettings settings;
    settings.direct_error = 0.03;
    radiosity::GroupedLight none;
    BakeCounts counts;
    const std::vector<Rgb> direct =
        bake_direct(input, settings, DimShares(input, settings), none, counts, Progress{});
    double baked = 0;
    for (std::uint32_t t = 0; t < direct.size(); ++t) {
      baked += static_cast<double>(direct[t].g) * input.texels.surface_of(input.texels.texels[t]);
    }
    // Light on a square of half side 3 m below: 100 cd times its solid angle, 4 atan(...).
    double lumens = 0;
    for (const double x : {3 - 1.13, 3 + 1.13}) {
      for (const double y : {3 - 0.67, 3 + 0.67}) {
        lumens += 100 * std::atan(x * y / (0.2 * std::sqrt(x * x + y * y + 0.04)));
      }
    }
    EXPECT_NEAR(baked / lumens, 1, 0.01) << lamps;
  }
}

}  // namespace
}  // namespace lightbatch::lightmap
