#include "core/optics/sky_suns.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/math/sobol.h"

namespace lightbatch::optics {
namespace {

image::ImageRgb grey_map(int rows, float value) {
  image::ImageRgb map(2 * rows, rows);
  for (Rgb& p : map.pixels) p = Rgb::grey(value);
  return map;
}

double solid_angle(int row, int rows) {
  const auto border = [&](int r) { return std::cos(kPiDouble * r / rows); };
  return (border(row) - border(row + 1)) * kPiDouble / rows;
}

TEST(SkySuns, SkiesWithoutOneStayAsTheyAre) {
  EXPECT_TRUE(split_suns(Environment()).suns.empty());
  EXPECT_TRUE(split_suns(Environment(Rgb::grey(5))).suns.empty());
  image::ImageRgb map = grey_map(64, 10);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 40; ++x) map.at(x, y) = Rgb::grey(100);  // a bright cloud
  }
  map.at(3, 10) = Rgb::grey(400);  // its edge: too little to matter
  const Environment cloudy(map);
  const SplitSky split = split_suns(cloudy);
  EXPECT_TRUE(split.suns.empty());
  EXPECT_EQ(split.rest.map(), cloudy.map());
}

TEST(SkySuns, APixelIsOneAndNoLightIsLost) {
  constexpr int kRows = 128;
  for (const float sky : {0.0f, 1000.0f}) {
    image::ImageRgb map = grey_map(kRows, sky);
    map.at(200, 40) = {3e8f, 2e8f, 1e8f};
    const Environment whole(map);
    const SplitSky split = split_suns(whole);
    ASSERT_EQ(split.suns.size(), 1u);
    const SkySun& sun = split.suns[0];
    const Vec3f centre = sun.towards();
    EXPECT_EQ(whole.radiance(centre), map.at(200, 40));
    // What is left there is no brighter than a multiple of the sky.
    EXPECT_LE(split.rest.radiance(centre).sum(), 40 * 3 * sky);
    const double flux = static_cast<double>(sun.illuminance().g) / (4 * kPiDouble);
    EXPECT_NEAR(flux + split.rest.mean().g, whole.mean().g, 2e-4 * whole.mean().g);
    EXPECT_NEAR(static_cast<double>(sun.illuminance().r / sun.illuminance().b), 3.0, 1e-3);
    const OwenSobol2 random(7);
    for (std::uint32_t i = 0; i < 64; ++i) {
      EXPECT_EQ(whole.radiance(sun.direction(random.point(i))), map.at(200, 40));
    }
  }
}

TEST(SkySuns, DirectionsComeAsOftenAsTheirLight) {
  constexpr int kRows = 256;
  image::ImageRgb map = grey_map(kRows, 1);
  map.at(100, 90) = Rgb::grey(1e6f);
  map.at(101, 90) = Rgb::grey(3e6f);
  const Environment whole(map);
  const SplitSky split = split_suns(whole);
  ASSERT_EQ(split.suns.size(), 1u);
  const OwenSobol2 random(3);
  int right = 0;
  for (std::uint32_t i = 0; i < 4096; ++i) {
    if (whole.radiance(split.suns[0].direction(random.point(i))).r > 2e6f) ++right;
  }
  EXPECT_NEAR(right / 4096.0, 0.75, 0.01);
  EXPECT_NEAR(static_cast<double>(split.suns[0].illuminance().r), 4e6 * solid_angle(90, kRows),
              1e-3 * 4e6 * solid_angle(90, kRows));
}

TEST(SkySuns, WideLightsAreCutIntoNarrowOnes) {
  constexpr int kRows = 128;
  image::ImageRgb map = grey_map(kRows, 1);
  for (int x = 20; x < 40; ++x) map.at(x, 60) = Rgb::grey(1e5f);  // 28 degrees long
  map.at(150, 30) = Rgb::grey(1e6f);
  const SplitSky split = split_suns(Environment(map));
  EXPECT_GE(split.suns.size(), 4u);
  EXPECT_LE(split.suns.size(), 16u);
  const OwenSobol2 random(5);
  for (const SkySun& sun : split.suns) {
    for (std::uint32_t i = 0; i < 256; ++i) {
      EXPECT_GT(dot(sun.towards(), sun.direction(random.point(i))), std::cos(0.12f));
    }
  }
}

TEST(SkySuns, StarsAreTooMany) {
  image::ImageRgb map = grey_map(128, 1);
  for (int y = 4; y < 124; y += 8) {
    for (int x = 4; x < 256; x += 16) map.at(x, y) = Rgb::grey(1e4f);
  }
  const SplitSky split = split_suns(Environment(map));
  EXPECT_TRUE(split.suns.empty());
  EXPECT_EQ(split.rest.mean().r, Environment(map).mean().r);
}

TEST(SkySuns, TheStrongestCounts) {
  image::ImageRgb map = grey_map(64, 0);
  map.at(3, 3) = Rgb::grey(static_cast<float>(kMostRadiance));
  const SplitSky split = split_suns(Environment(map));
  ASSERT_EQ(split.suns.size(), 1u);
  EXPECT_TRUE(std::isfinite(split.suns[0].illuminance().r));
  EXPECT_TRUE(split.rest.is_black());
}

}  // namespace
}  // namespace lightbatch::optics
