#include "core/lightmap/block_curve.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <vector>

namespace lightbatch::lightmap {
namespace {

constexpr Block kBlock{0, 3, 5, 11, 9};
constexpr std::array<std::uint32_t, 4> kCorner{0, 1, 2, 3};
constexpr std::uint32_t kMiddle = 4;

/// What a block shows at a texel whose corners and middle hold light(s, t), without noise but for
/// `variance` of each.
struct Filled {
  std::vector<GatheredTexel> texel;
  std::array<float, 4> at_middle = corner_shares(kBlock, 7, 7);
  BlockCurve curve;

  Filled(const std::function<float(float, float)>& light, float variance)
      : texel(made(light, variance)),
        curve(middle_off(texel, kCorner, kMiddle, at_middle), at_middle) {
    curve.keep_positive(kCorner, kMiddle, [&](std::uint32_t t) { return texel[t].irradiance; });
  }
  static std::vector<GatheredTexel> made(const std::function<float(float, float)>& light,
                                         float variance) {
    std::vector<GatheredTexel> texel(5);
    constexpr float kAt[5][2] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}, {0.5f, 0.5f}};
    for (std::size_t i = 0; i < 5; ++i) {
      texel[i].irradiance = Rgb::grey(light(kAt[i][0], kAt[i][1]));
      texel[i].variance = variance;
    }
    return texel;
  }
  float at(int x, int y) const {
    std::array<float, 4> share = corner_shares(kBlock, x, y);
    const float of_middle = curve.of_middle(share);
    float sum = of_middle, value = texel[kMiddle].irradiance.g * of_middle;
    for (std::size_t i = 0; i < 4; ++i) {
      sum += share[i];
      value += texel[i].irradiance.g * share[i];
    }
    EXPECT_NEAR(sum, 1, 1e-6f);
    return value;
  }
};

template <typename Visit>
void for_each_texel(Visit visit) {
  for (int y = kBlock.y0; y <= kBlock.y1; ++y) {
    for (int x = kBlock.x0; x <= kBlock.x1; ++x) {
      visit(x, y, static_cast<float>(x - 3) / 8, static_cast<float>(y - 5) / 4);
    }
  }
}

TEST(BlockCurve, EvenCurvatureIsExact) {
  const auto bowl = [](float s, float t) { return 7 + s - 2 * t + 3 * (s * s + t * t); };
  const Filled block(bowl, 0);
  for_each_texel([&](int x, int y, float s, float t) {
    EXPECT_NEAR(block.at(x, y), bowl(s, t), 1e-5f) << s << " " << t;
  });
}

// Light along a wall bends one way only: right in the mean, where corners alone are 8 % too bright.
TEST(BlockCurve, CurvatureOneWayIsRightInTheMean) {
  const auto along = [](float s, float) { return 2 - 1.5f * s * (1 - s); };
  const Filled block(along, 0);
  double sum = 0, exact = 0;
  for_each_texel([&](int x, int y, float s, float t) {
    const bool rim = s == 0 || s == 1 || t == 0 || t == 1;
    if (rim) return;
    sum += static_cast<double>(block.at(x, y));
    exact += static_cast<double>(along(s, t));
  });
  EXPECT_NEAR(sum / exact, 1, 0.02);
}

TEST(BlockCurve, NoiseIsNotTakenForCurvature) {
  const auto bent = [](float s, float t) { return s == 0.5f && t == 0.5f ? 1.1f : 1.0f; };
  EXPECT_NEAR(Filled(bent, 0).at(7, 7), 1.1f, 1e-6f);
  EXPECT_NEAR(Filled(bent, 0.01f / 1.25f).at(7, 7), 1.05f, 1e-5f);
  EXPECT_NEAR(Filled(bent, 1.0f).at(7, 7), 1.0f, 2e-3f);
}

// The middle and three corners are dark: a bend would take light from them that they have not.
TEST(BlockCurve, LightStaysPositive) {
  const auto corner = [](float s, float t) { return s * t == 1 ? 1.0f : 0.0f; };
  const Filled block(corner, 0);
  for_each_texel([&](int x, int y, float, float) { EXPECT_GE(block.at(x, y), 0.0f); });
}

TEST(BlockCurve, TheFaintestLightStaysFinite) {
  GatheredTexel dark, faint;
  faint.irradiance = Rgb::grey(1e-45f);
  const std::array<float, 4> at_middle = corner_shares(kBlock, 7, 7);
  BlockCurve curve({Rgb::grey(1), 0}, at_middle);
  curve.keep_positive(kCorner, kMiddle, [&](std::uint32_t t) {
    return (t == 3 || t == kMiddle ? dark : faint).irradiance * (t == kMiddle ? 1.0f : 4.0f);
  });
  std::array<float, 4> share = corner_shares(kBlock, 6, 6);
  EXPECT_TRUE(std::isfinite(curve.of_middle(share)));
}

// Beyond what a float can square nothing is known of noise, and nothing is bent.
TEST(BlockCurve, StrongLightStaysFinite) {
  const auto strong = [](float s, float t) { return s == 0.5f && t == 0.5f ? 2e22f : 1e22f; };
  const Filled block(strong, 0);
  for_each_texel([&](int x, int y, float, float) { EXPECT_EQ(block.at(x, y), 1e22f); });
}

TEST(BlockCurve, ARowOfTexelsBendsToo) {
  constexpr Block kRow{0, 0, 2, 8, 2};
  const std::array<float, 4> at_middle = corner_shares(kRow, 4, 2);
  const std::vector<GatheredTexel> texel =
      Filled::made([](float s, float t) { return s == 0.5f && t == 0.5f ? 2.0f : 1.0f; }, 0);
  const BlockCurve curve(middle_off(texel, kCorner, kMiddle, at_middle), at_middle);
  std::array<float, 4> share = corner_shares(kRow, 4, 2);
  EXPECT_NEAR(curve.of_middle(share), 1, 1e-6f);
}

}  // namespace
}  // namespace lightbatch::lightmap
