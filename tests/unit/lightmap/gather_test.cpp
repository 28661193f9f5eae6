#include "core/lightmap/gather.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/lightmap/lit_scene.h"

namespace lightbatch::lightmap {
namespace {

// A sheared box, acute at two of its edges, whose walls glow: light is the same everywhere, and of
// it the share that walls reflect comes by the gather. In the corners every hit is near, and light
// comes by long walks: that these end at random, and ask one wall of many, must not show. The rms
// is 0.5 %; were nothing to stand for a walk that ends, 0.8 %; were walls chosen by the middles of
// their boxes besides, 0.9 %.
TEST(Gather, WalksInAcuteCornersAreQuiet) {
  constexpr float kReflectance = 0.9f, kLux = 50;
  LitScene lit;
  const float glow = (1 - kReflectance) * kLux / kPi;
  const std::uint32_t wall = lit.kit.material(Rgb::grey(kReflectance), Rgb::grey(glow));
  lit.kit.box({0, 0, 0}, {2, 0.5f, 2}, wall);
  for (Vec3f& p : lit.kit.scene().positions) p.x += 2 * p.y;
  lit.edge = 0.05;
  lit.solve();
  lit.chart(8);
  GatherSettings settings;
  settings.rays = 512;
  settings.block = 1;
  radiosity::GroupedLight none;
  BakeCounts counts;
  const DimShares dim(lit.input(), settings);
  const auto light = bake_indirect(lit.input(), settings, dim, none, counts, Progress{});
  EXPECT_GT(counts.deeper_gathers, 10'000u);
  double sum = 0, squares = 0, worst = 0;
  for (const Rgb& at : light) {
    const double off = static_cast<double>(at.g / (kReflectance * kLux)) - 1;
    sum += off;
    squares += off * off;
    worst = std::max(worst, std::abs(off));
  }
  const auto count = static_cast<double>(light.size());
  EXPECT_NEAR(sum / count, 0, 0.001);
  EXPECT_LT(std::sqrt(squares / count), 0.006);
  EXPECT_LT(worst, 0.1);
}

}  // namespace
}  // namespace lightbatch::lightmap
