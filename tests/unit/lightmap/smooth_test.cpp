#include "core/lightmap/smooth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/base/random.h"
#include "core/lightmap/neighbours.h"

namespace lightbatch::lightmap {
namespace {

constexpr int kSide = 64;
constexpr float kSigma = 0.1f;

radiosity::GroupedLight none;

/// One flat chart of kSide^2 texels at 10 a metre.
struct Flat {
  atlas::Layout layout;
  atlas::TexelMap map;
  std::vector<GatheredTexel> texels;

  /// distance: harmonic mean length of rays, metres.
  Flat(const std::function<float(int, int)>& truth, float distance) {
    layout.texels_per_metre = 10;
    layout.pages.push_back({kSide, kSide});
    layout.charts.emplace_back();
    map.index.emplace_back();
    Random random(1);
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        map.index[0].push_back(static_cast<std::uint32_t>(map.texels.size()));
        atlas::Texel place;
        place.x = static_cast<std::uint16_t>(x);
        place.y = static_cast<std::uint16_t>(y);
        map.texels.push_back(place);
        GatheredTexel t;
        // Uniform noise of standard deviation kSigma.
        const float noise = kSigma * std::sqrt(12.0f) * (random.next_float() - 0.5f);
        t.irradiance = Rgb::grey(truth(x, y) + noise);
        t.variance = kSigma * kSigma;
        t.normal = {0, 1, 0};
        t.distance = distance;
        t.gathered = true;
        texels.push_back(t);
      }
    }
  }

  /// Root of the mean square off the truth, eight texels off the border.
  float off(const std::function<float(int, int)>& truth) const {
    float squares = 0;
    int count = 0;
    for (int y = 8; y < kSide - 8; ++y) {
      for (int x = 8; x < kSide - 8; ++x) {
        const float d = texels[static_cast<std::size_t>(y * kSide + x)].irradiance.g - truth(x, y);
        squares += d * d;
        ++count;
      }
    }
    return std::sqrt(squares / static_cast<float>(count));
  }
};

float ramp(int x, int y) {
  return 1 + 0.01f * static_cast<float>(x) + 0.02f * static_cast<float>(y);
}

// A ramp passes unchanged: what is left is noise. Nine texels of one pass leave a third of it;
// pairs that fail the test by chance some more. Four passes reach over 15 x 15 texels.
TEST(Smooth, NoiseOnARampFalls) {
  Flat open(ramp, 100);
  smooth_gathered(open.layout, open.map, 1.0, open.texels, none);
  EXPECT_LT(open.off(ramp), kSigma / 7);
  // Something is close: only next neighbours count.
  Flat closed(ramp, 0.15f);
  smooth_gathered(closed.layout, closed.map, 1.0, closed.texels, none);
  EXPECT_LT(closed.off(ramp), kSigma / 2.2f);
  EXPECT_GT(closed.off(ramp), kSigma / 4);
}

TEST(Smooth, AnEdgeStaysWhereItIs) {
  const auto edge = [](int x, int) { return x < kSide / 2 ? 1.0f : 3.0f; };
  Flat flat(edge, 100);
  smooth_gathered(flat.layout, flat.map, 1.0, flat.texels, none);
  for (int y = 8; y < kSide - 8; ++y) {
    const auto at = [&](int x) {
      return flat.texels[static_cast<std::size_t>(y * kSide + x)].irradiance.g;
    };
    EXPECT_LT(at(kSide / 2 - 1), 1.4f) << y;
    EXPECT_GT(at(kSide / 2), 2.6f) << y;
  }
  EXPECT_LT(flat.off(edge), kSigma / 4);
}

TEST(Smooth, CoveredAndSharedTexelsStayApart) {
  const auto dark_half = [](int x, int) { return x < kSide / 2 ? 1.0f : 1.2f; };
  Flat flat(dark_half, 100);
  for (std::size_t i = 0; i < flat.texels.size(); ++i) {
    flat.texels[i].covered = flat.map.texels[i].x < kSide / 2;
    flat.texels[i].irradiance = Rgb::grey(flat.texels[i].covered ? 1.0f : 1.2f);
  }
  flat.texels[0].gathered = false;
  flat.texels[0].irradiance = Rgb::grey(7);
  smooth_gathered(flat.layout, flat.map, 1.0, flat.texels, none);
  EXPECT_EQ(flat.texels[0].irradiance.g, 7);
  EXPECT_NEAR(flat.off(dark_half), 0, 1e-6);
}

TEST(Neighbours, OppositeOnesAreAsFarAsAsked) {
  const Flat flat(ramp, 1);
  const std::uint32_t t = 20 * kSide + 30;
  const auto at = neighbourhood(flat.map, flat.layout, t, 4);
  EXPECT_EQ(at[4], t);
  EXPECT_EQ(at[0], 16u * kSide + 26);
  EXPECT_EQ(at[8], 24u * kSide + 34);
  EXPECT_EQ(neighbourhood(flat.map, flat.layout, 2 * kSide + 3, 4)[0], scene::kNone);
}

}  // namespace
}  // namespace lightbatch::lightmap
