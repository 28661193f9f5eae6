#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/accuracy/leaks.h"
#include "core/accuracy/seams.h"
#include "core/base/parallel.h"
#include "tests/unit/accuracy/hand_laid_map.h"

namespace lightbatch::accuracy {
namespace {

const optics::Environment kBlackSky;

struct Map : HandLaidMap {
  Seams seams(double mean) const {
    return measure_seams(kit.scene(), kit.caster(), layout, texels, pages, mean);
  }
  Leaks leaks(double mean) const {
    const PathTracer tracer(kit.caster(), kit.optics(), kBlackSky);
    LeakOptions options;
    options.mean_irradiance = mean;
    const auto found =
        find_leaks(tracer, kit.caster(), kit.scene(), layout, texels, pages, options, Progress());
    EXPECT_TRUE(found.ok());
    return *found;
  }
};

TEST(Seams, StepOfKnownHeight) {
  Map map;
  const std::uint32_t grey = map.kit.material(Rgb::grey(0.5f));
  map.kit.quad(floor(0, 1), grey);
  map.kit.quad(floor(1, 3), grey);
  map.lay_out([](std::uint32_t chart, int, int) { return chart == 0 ? 4.0f : 4.4f; });
  const Seams seams = map.seams(4);
  EXPECT_NEAR(seams.flat.metres, 2, 1e-6);
  EXPECT_EQ(seams.flat.points, 20u);
  EXPECT_NEAR(seams.flat.rms, 0.1, 1e-6);
  EXPECT_NEAR(seams.flat.p95, 0.1, 1e-6);
  EXPECT_NEAR(seams.flat.largest, 0.1, 1e-6);
  EXPECT_EQ(seams.folded.points, 0u);
}

TEST(Seams, NoneWhereLightGoesOnAcrossTheBorder) {
  Map map;
  const std::uint32_t grey = map.kit.material(Rgb::grey(0.5f));
  map.kit.quad(floor(0, 1), grey);
  map.kit.quad(floor(1, 3), grey);
  map.lay_out([](std::uint32_t chart, int x, int) {
    return 1 + 0.1f * static_cast<float>(x + (chart == 0 ? 0 : 10));
  });
  const Seams seams = map.seams(2);
  EXPECT_EQ(seams.flat.points, 20u);
  EXPECT_LT(seams.flat.largest, 1e-5);
}

TEST(Seams, PooledByLength) {
  Map map;
  const std::uint32_t grey = map.kit.material(Rgb::grey(0.5f));
  map.kit.quad(floor(0, 1), grey);
  map.kit.quad(floor(1, 2), grey);
  map.lay_out([](std::uint32_t chart, int, int y) {
    return chart == 0 || y < 11 ? 1.0f : 1.2f;  // a step of 0.2 over the second metre
  });
  const Seams seams = map.seams(1);
  // Of 20 points nine see the whole step, one half of it.
  EXPECT_NEAR(seams.flat.rms, 0.2 * std::sqrt((9 + 0.25) / 20), 1e-6);
  EXPECT_NEAR(seams.flat.p95, 0.2, 1e-6);
}

TEST(Seams, NeighboursWithoutASharedEdge) {
  Map map;
  const std::uint32_t grey = map.kit.material(Rgb::grey(0.5f));
  map.kit.quad(floor(0, 1), grey);
  map.kit.quad(floor(1, 2, 1), grey);  // half as deep: the corners of its edge are others
  map.lay_out([](std::uint32_t chart, int, int) { return chart == 0 ? 1.0f : 1.5f; });
  const Seams seams = map.seams(1);
  EXPECT_NEAR(seams.flat.metres, 1, 1e-6);
  EXPECT_NEAR(seams.flat.rms, 0.5, 1e-6);
}

TEST(Seams, FoldsAndCorners) {
  Map map;
  const std::uint32_t grey = map.kit.material(Rgb::grey(0.5f));
  map.kit.quad(floor(0, 1), grey);
  map.kit.quad(floor(1, 2, 2, 0.1f), grey);                               // 5.7 degrees
  map.kit.quad({Vec3f{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, grey);  // a wall: no seam
  map.lay_out([](std::uint32_t chart, int, int) { return 1 + static_cast<float>(chart); });
  const Seams seams = map.seams(1);
  EXPECT_EQ(seams.flat.points, 0u);
  EXPECT_NEAR(seams.folded.metres, 2, 1e-6);
  EXPECT_NEAR(seams.folded.rms, 1, 1e-6);
}

TEST(Seams, WallOnTheBorderDivides) {
  Map map;
  const std::uint32_t grey = map.kit.material(Rgb::grey(0.5f));
  map.kit.quad(floor(0, 1), grey);
  map.kit.quad(floor(1, 2), grey);
  map.kit.quad({Vec3f{1, 0, 0}, {1, 0, 2}, {1, 1, 2}, {1, 1, 0}}, grey);
  map.lay_out([](std::uint32_t chart, int, int) { return 1 + static_cast<float>(chart); });
  const Seams seams = map.seams(1);
  EXPECT_EQ(seams.flat.points, 0u);
  EXPECT_NEAR(seams.divided_metres, 2, 1e-6);
}

/// A closed dark box of 2 m, and beside it, facing away, a floor of its own under a lamp.
struct DarkRoom : Map {
  explicit DarkRoom(float shown) {
    const std::uint32_t grey = kit.material(Rgb::grey(0.5f));
    kit.box({0, 0, 0}, {2, 2, 2}, grey);
    const std::uint32_t lit = kit.quad({Vec3f{4, 0, 2}, {6, 0, 2}, {6, 0, 0}, {4, 0, 0}}, grey) / 2;
    kit.quad({Vec3f{4, 1, 0}, {6, 1, 0}, {6, 1, 2}, {4, 1, 2}},
             kit.material(Rgb::grey(0), Rgb::grey(10)));
    lay_out([=](std::uint32_t chart, int x, int) {
      if (chart >= lit) return 1.0f;
      return chart == 0 && x < 5 ? shown : 0.0f;  // a quarter of one wall
    });
  }
};

TEST(Leaks, LightInAClosedRoomIsFound) {
  const Leaks leaks = DarkRoom(0.5f).leaks(1);
  EXPECT_GT(leaks.points, 1000u);
  EXPECT_GT(leaks.leaks, 100u);
  // Columns 0 to 4 and what is interpolated of the next, of 20, of a wall of 4 m2; 32 m2 in all.
  EXPECT_NEAR(leaks.area_share, 0.235 * 4 / 32, 0.004);
  EXPECT_NEAR(leaks.largest, 0.5, 1e-6);
  EXPECT_LT(leaks.triangle, 2u);
}

TEST(Leaks, NoneWhereDarkIsDark) {
  const Leaks leaks = DarkRoom(0).leaks(1);
  EXPECT_GT(leaks.points, 1000u);
  EXPECT_EQ(leaks.leaks, 0u);
  EXPECT_EQ(leaks.area_share, 0);
}

TEST(Leaks, InsidesOfSolidsAreHidden) {
  Map map;
  const std::uint32_t grey = map.kit.material(Rgb::grey(0.5f));
  map.kit.quad(floor(0, 2), grey);
  map.kit.box({0.2f, -0.01f, 0.2f}, {1.8f, 1, 1.8f}, grey, false);
  map.lay_out([](std::uint32_t, int, int) { return 1.0f; });
  const Leaks leaks = map.leaks(1);
  EXPECT_GT(leaks.hidden, 100u);
}

TEST(Borders, SameOnAnyNumberOfThreads) {
  const int before = thread_count();
  std::vector<std::array<double, 3>> figures;
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    const DarkRoom room(0.5f);
    const Leaks leaks = room.leaks(1);
    const Seams seams = room.seams(1);
    figures.push_back({leaks.area_share, leaks.largest, seams.flat.rms});
  }
  set_thread_count(before);
  EXPECT_EQ(figures[0], figures[1]);
}

}  // namespace
}  // namespace lightbatch::accuracy
