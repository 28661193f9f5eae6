#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/radiosity/linked_solver.h"
#include "tests/unit/radiosity/bench.h"

namespace lightbatch::radiosity {
namespace {

using accuracy::SceneKit;
constexpr double kPiD = std::numbers::pi;

SolverOptions options_of(double threshold) {
  SolverOptions o;
  o.threshold = threshold;
  o.tolerance = 1e-6;
  return o;
}

// Every face emits 1 nit: E = pi / (1 - rho) everywhere. Rows are scaled to sum to 1, so the
// deviation is what the direct part has, and the mean is right at any reflectance.
TEST(Linked, EmptyFurnace) {
  for (const float rho : {0.5f, 0.9f, 0.99f}) {
    SceneKit kit;
    kit.box({0, 0, 0}, {2, 1, 3}, kit.material(Rgb::grey(rho), {1, 1, 1}));
    kit.finish();
    const Bench bench(kit, 0.25);
    const Solution s = solve_linked(bench.input, options_of(1e-4), Progress()).value();
    const auto [mean, worst] = bench.against(s, kPiD / (1 - static_cast<double>(rho)));
    EXPECT_NEAR(mean, 1, 5e-4) << rho;
    EXPECT_LT(worst, 0.02) << rho;
    EXPECT_LT(s.statistics.iterations, 60) << rho;
    EXPECT_GT(s.statistics.links, 100u);
  }
}

// Thirty boxes in the room: clusters, cut sight lines, dark pockets.
TEST(Linked, FurnishedFurnace) {
  SceneKit kit;
  const std::uint32_t all = kit.material(Rgb::grey(0.99f), {1, 1, 1});
  kit.box({0, 0, 0}, {4, 4, 4}, all);
  Random random(3);
  for (int i = 0; i < 27; ++i) {  // one in each cell of a grid: none overlap
    const Vec3f cell{static_cast<float>(i % 3), static_cast<float>(i / 3 % 3),
                     static_cast<float>(i / 9)};
    const Vec3f a =
        cell * 1.3f + Vec3f{0.1f + 0.4f * random.next_float(), 0.1f + 0.4f * random.next_float(),
                            0.1f + 0.4f * random.next_float()};
    const Vec3f size{0.1f + 0.5f * random.next_float(), 0.1f + 0.5f * random.next_float(),
                     0.1f + 0.5f * random.next_float()};
    kit.box(a, a + size, all, false);
  }
  kit.finish();
  const Bench bench(kit, 0.3);
  const Solution s = solve_linked(bench.input, options_of(1e-3), Progress()).value();
  // Direct light is sampled, and the answer is 100 times it: compare with what was sampled.
  double area = 0;
  for (ElementId e = 0; e < bench.elements.count(); ++e) {
    area += static_cast<double>(bench.elements.area(e));
  }
  const double direct = s.statistics.emitted.g / area;
  EXPECT_NEAR(direct / kPiD, 1, 0.05);
  const auto [mean, worst] = bench.against(s, direct / (1 - 0.99));
  EXPECT_NEAR(mean, 1, 0.01);  // rays that slip through edges: some 1e-5, times 99
  EXPECT_LT(worst, 0.05);
}

// A lamp under the ceiling of a room with a block, reflectance 0.2 to 0.7, against the stored-ray
// mode at 512 rays: the same light within 1 % in the mean and 2 % anywhere, mean square.
TEST(Linked, AgreesWithStoredRays) {
  SceneKit kit;
  kit.box({0, 0, 0}, {3, 3, 3}, kit.material(Rgb{0.5f, 0.7f, 0.2f}));
  kit.box({1, 0.01f, 1}, {1.6f, 1.2f, 1.6f}, kit.material(Rgb::grey(0.6f)), false);
  kit.quad({Vec3f{1, 2.99f, 1}, {2, 2.99f, 1}, {2, 2.99f, 2}, {1, 2.99f, 2}},
           kit.material(Rgb{}, {10, 10, 10}));
  kit.finish();
  const Bench bench(kit, 0.25);
  SolverOptions o = options_of(1e-6);
  o.direct_samples = 32;
  const Solution linked = solve_linked(bench.input, o, Progress()).value();
  o.rays = 512;
  const Solution stored = solve_stored_rays(bench.input, o, Progress()).value();
  double square = 0, mean = 0, bias = 0, area = 0;
  for (ElementId e = 0; e < bench.elements.count(); ++e) {
    const double a = static_cast<double>(bench.elements.area(e));
    const double x = static_cast<double>(linked.irradiance[e].g);
    const double y = static_cast<double>(stored.irradiance[e].g);
    square += a * (x - y) * (x - y);
    bias += a * (x - y);
    mean += a * y;
    area += a;
  }
  mean /= area;
  EXPECT_NEAR(bias / area / mean, 0, 0.01);
  EXPECT_LT(std::sqrt(square / area) / mean, 0.02);
  // Absorbed + escaped = emitted.
  const auto& st = linked.statistics;
  EXPECT_NEAR((st.absorbed.g + st.escaped.g) / st.emitted.g, 1, 1e-3);
}

// Under an open sky a lone floor receives pi L and links nothing.
TEST(Linked, LoneFloorUnderSky) {
  SceneKit kit;
  kit.quad({Vec3f{-5, 0, 5}, {5, 0, 5}, {5, 0, -5}, {-5, 0, -5}}, kit.material(Rgb::grey(0.8f)));
  kit.finish();
  const Bench bench(kit, 0.5, optics::Environment(Rgb{100, 100, 100}));
  const Solution s = solve_linked(bench.input, options_of(1e-4), Progress()).value();
  const auto [mean, worst] = bench.against(s, 100 * kPiD);
  EXPECT_NEAR(mean, 1, 1e-5);
  EXPECT_LT(worst, 1e-5);
  EXPECT_EQ(s.statistics.links, 0u);
}

TEST(Linked, BlackAndEmptyScenes) {
  SceneKit kit;
  kit.box({0, 0, 0}, {1, 1, 1}, kit.material(Rgb::grey(0.5f)));
  kit.finish();
  const Bench bench(kit, 0.3);
  const Solution s = solve_linked(bench.input, options_of(1e-4), Progress()).value();
  for (const Rgb& e : s.irradiance) EXPECT_TRUE(e.is_black());
  SceneKit nothing;
  nothing.material(Rgb{});
  nothing.finish();
  const Bench empty(nothing, 0.3);
  EXPECT_EQ(solve_linked(empty.input, options_of(1e-4), Progress()).value().irradiance.size(), 0u);
}

TEST(Linked, SameOnAnyNumberOfThreads) {
  SceneKit kit;
  kit.box({0, 0, 0}, {2, 1, 3}, kit.material(Rgb::grey(0.7f), {1, 1, 1}));
  kit.box({0.5f, 0.2f, 0.5f}, {1, 0.6f, 1}, kit.material(Rgb::grey(0.3f)), false);
  kit.finish();
  const Bench bench(kit, 0.3);
  set_thread_count(1);
  const Solution one = solve_linked(bench.input, options_of(1e-4), Progress()).value();
  set_thread_count(2);
  const Solution two = solve_linked(bench.input, options_of(1e-4), Progress()).value();
  EXPECT_EQ(one.irradiance, two.irradiance);
  EXPECT_EQ(one.radiosity, two.radiosity);
}

// The clusters' claim: the same surfaces in 64 times the triangles cost about the same links.
TEST(Linked, LinksDoNotFollowTriangles) {
  std::array<std::uint64_t, 2> links{}, triangles{};
  for (std::size_t fine = 0; fine < 2; ++fine) {
    SceneKit kit;
    const std::uint32_t grey = kit.material(Rgb::grey(0.5f));
    const std::uint32_t lamp = kit.material(Rgb{}, {10, 10, 10});
    kit.box({0, 0, 0}, {4, 3, 4}, grey);
    kit.quad({Vec3f{1, 2.99f, 1}, {2, 2.99f, 1}, {2, 2.99f, 2}, {1, 2.99f, 2}}, lamp);
    // Slanted plates about the room, each of 1 or of 8 by 8 quads.
    const int n = fine == 1 ? 8 : 1;
    for (int i = 0; i < 40; ++i) {
      Random random(item_seed(7, static_cast<std::uint64_t>(i)));
      const auto draw = [&](float low, float high) {
        return low + (high - low) * random.next_float();
      };
      const Vec3f at{draw(0.3f, 3.3f), draw(0.2f, 2.2f), draw(0.3f, 3.3f)};
      const Vec3f u{draw(0.1f, 0.2f), draw(-0.1f, 0.1f), draw(0, 0.1f)};
      const Vec3f v{draw(0, 0.05f), draw(0.1f, 0.2f), draw(0, 0.1f)};
      for (int k = 0; k < n * n; ++k) {
        const float step = 1 / static_cast<float>(n);
        const Vec3f a =
            at + u * (static_cast<float>(k % n) * step) + v * (static_cast<float>(k / n) * step);
        kit.quad({a, a + u * step, a + u * step + v * step, a + v * step}, grey);
      }
    }
    kit.finish();
    const Bench bench(kit, 0.25);
    triangles[fine] = kit.scene().triangles.size();
    links[fine] = solve_linked(bench.input, options_of(1e-4), Progress()).value().statistics.links;
  }
  EXPECT_GT(triangles[1], 50 * triangles[0]);
  EXPECT_LT(static_cast<double>(links[1]), 1.3 * static_cast<double>(links[0]));
}

}  // namespace
}  // namespace lightbatch::radiosity
