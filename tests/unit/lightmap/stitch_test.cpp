#include "core/lightmap/stitch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/accuracy/seams.h"
#include "core/base/parallel.h"
#include "core/base/random.h"
#include "tests/unit/accuracy/hand_laid_map.h"

namespace lightbatch::lightmap {
namespace {

constexpr double kPlenty = 1e9;  // lux that texels may change by

/// A floor in two charts that meet in a line of 2 m, 10 texels a metre.
struct Floor : accuracy::HandLaidMap {
  template <typename Value>
  explicit Floor(Value value) {
    const std::uint32_t grey = kit.material(Rgb::grey(0.5f));
    kit.quad(accuracy::floor(0, 1), grey);
    kit.quad(accuracy::floor(1, 3), grey);
    lay_out(value);
  }
  Stitches stitches(double allowed) const {
    return {layout, find_borders(kit.scene(), kit.caster(), layout, texels, {0.25, 0.75}), pages,
            allowed};
  }
  double step(const std::vector<PageImage>& of, double mean) const {
    return accuracy::measure_seams(kit.scene(), kit.caster(), layout, texels, of, mean).flat.rms;
  }
  /// Root of the mean square over the covered area.
  double change(const std::vector<PageImage>& other) const {
    double squares = 0, area = 0;
    for (std::size_t i = 0; i < pages[0].coverage.size(); ++i) {
      const auto covered = static_cast<double>(pages[0].coverage[i]);
      const auto d =
          static_cast<double>(other[0].irradiance.pixels[i].g - pages[0].irradiance.pixels[i].g);
      squares += covered * d * d;
      area += covered;
    }
    return std::sqrt(squares / area);
  }
};

float noisy(std::uint32_t chart, int x, int y) {
  Random random(item_seed(7, static_cast<std::uint64_t>((x + 50 * y)), chart));
  return 10 + 2 * (random.next_float() - 0.5f);
}

TEST(Stitches, NoiseNoLongerStepsAcrossTheBorder) {
  const Floor floor(noisy);
  auto pages = floor.pages;
  floor.stitches(kPlenty).apply(pages);
  EXPECT_GT(floor.step(floor.pages, 10), 0.03);
  // A twentieth is left where both sides hold.
  EXPECT_LT(floor.step(pages, 10), 0.1 * floor.step(floor.pages, 10));
  // Noise is averaged: texels move by less than what they are off by.
  EXPECT_LT(floor.change(pages), 0.5 * 2 / std::sqrt(12.0));
}

TEST(Stitches, LightThatGoesOnAcrossTheBorderStays) {
  const Floor floor([](std::uint32_t chart, int x, int) {
    return 1 + 0.1f * static_cast<float>(x + (chart == 0 ? 0 : 10));
  });
  auto pages = floor.pages;
  floor.stitches(kPlenty).apply(pages);
  EXPECT_LT(floor.change(pages), 1e-5);
}

TEST(Stitches, TexelsChangeByNoMoreThanAllowed) {
  const Floor floor([](std::uint32_t chart, int, int) { return chart == 0 ? 4.0f : 6.0f; });
  for (const double allowed : {0.3, 0.1, 0.03}) {
    auto pages = floor.pages;
    floor.stitches(allowed).apply(pages);
    EXPECT_LE(floor.change(pages), allowed);
    EXPECT_GT(floor.change(pages), 0);
  }
}

TEST(Stitches, DarkStaysDark) {
  const Floor floor([](std::uint32_t chart, int, int) { return chart == 0 ? 0.0f : 6.0f; });
  auto pages = floor.pages;
  floor.stitches(kPlenty).apply(pages);
  EXPECT_EQ(floor.change(pages), 0);
}

TEST(Stitches, PartsAddUpToTheWhole) {
  const Floor floor(noisy);
  auto whole = floor.pages, part = floor.pages, rest = floor.pages;
  for (std::size_t i = 0; i < part[0].irradiance.pixels.size(); ++i) {
    const float share = 0.2f + 0.6f * static_cast<float>(i % 3) / 2;
    part[0].irradiance.pixels[i] = floor.pages[0].irradiance.pixels[i] * share;
    rest[0].irradiance.pixels[i] = floor.pages[0].irradiance.pixels[i] * (1 - share);
  }
  const Stitches stitches = floor.stitches(kPlenty);
  for (auto* pages : {&whole, &part, &rest}) stitches.apply(*pages);
  for (std::size_t i = 0; i < whole[0].irradiance.pixels.size(); ++i) {
    // The iteration ends at a residual of 1e-4 of steps of a tenth of the light.
    EXPECT_NEAR(part[0].irradiance.pixels[i].g + rest[0].irradiance.pixels[i].g,
                whole[0].irradiance.pixels[i].g, 1e-2);
  }
}

TEST(Stitches, SameBytesOnAnyNumberOfThreads) {
  const Floor floor(noisy);
  auto one = floor.pages, two = floor.pages;
  const int before = thread_count();
  set_thread_count(1);
  floor.stitches(0.1).apply(one);
  set_thread_count(2);
  floor.stitches(0.1).apply(two);
  set_thread_count(before);
  EXPECT_EQ(one[0].irradiance.pixels, two[0].irradiance.pixels);
}

}  // namespace
}  // namespace lightbatch::lightmap
