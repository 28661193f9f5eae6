#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/radiosity/solver.h"
#include "tests/unit/radiosity/bench.h"

namespace lightbatch::radiosity {
namespace {

using accuracy::SceneKit;

/// Few rays of a large floor land on small leaves above it: by these rays a leaf sends the floor
/// hundreds of times the light that it has, so that a balance of energy over all elements tells
/// nothing. No element takes more than all of what it sees, though, so that the answer is bounded.
TEST(StoredRays, SettleWhereFewRaysFindSmallElements) {
  constexpr float kReflectance = 0.8f;
  SceneKit kit;
  const std::uint32_t white = kit.material(Rgb::grey(kReflectance), Rgb{});
  kit.quad({Vec3f{-10, 0, 10}, {10, 0, 10}, {10, 0, -10}, {-10, 0, -10}}, white);
  Random random(7);
  for (int i = 0; i < 2000; ++i) {
    const Vec3f at{18 * random.next_float() - 9, 0.1f + random.next_float(),
                   18 * random.next_float() - 9};
    const Vec3f u{0.2f * random.next_float(), 0.2f * random.next_float() - 0.1f, 0.1f};
    const Vec3f v{0.1f, 0.2f * random.next_float() - 0.1f, 0.2f * random.next_float()};
    kit.quad({at, at + u, at + u + v, at + v}, white);
  }
  kit.finish();
  const Bench bench(kit, 20, optics::Environment(Rgb::grey(1)));
  for (const int rays : {2, 4, 8, 16, 24}) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      SolverOptions options;
      options.rays = rays;
      options.seed = seed;
      const auto solution = solve_stored_rays(bench.input, options, Progress{});
      ASSERT_TRUE(solution.ok());
      EXPECT_LT(solution->statistics.residual, options.tolerance) << rays << " " << seed;
      float most = 0;
      for (const Rgb& e : solution->irradiance) most = std::max(most, e.max());
      // The sky alone gives pi lux; all reflections together, 1 / (1 - rho) times as much.
      EXPECT_LE(most, kPi / (1 - kReflectance) * 1.001f) << rays << " " << seed;
    }
  }
}

/// A lamp that shines up, close below a ceiling: nearly all that it lights is hidden by it.
/// Elements of the ceiling that lie half above the lamp send on what is beside it, not their mean.
TEST(StoredRays, LampsCloseToACeilingAreSharp) {
  SceneKit kit;
  const std::uint32_t ceiling = kit.material(Rgb::grey(0.5f), Rgb{});
  const std::uint32_t black = kit.material(Rgb{}, Rgb{});
  kit.quad({Vec3f{-1.2f, 0, 1.2f}, {1.2f, 0, 1.2f}, {1.2f, 0, -1.2f}, {-1.2f, 0, -1.2f}}, black);
  kit.quad({Vec3f{-1.2f, 1, -1.2f}, {1.2f, 1, -1.2f}, {1.2f, 1, 1.2f}, {-1.2f, 1, 1.2f}}, ceiling);
  kit.quad({Vec3f{-0.55f, 0.98f, 0.7f},
            {0.75f, 0.98f, 0.7f},
            {0.75f, 0.98f, -0.6f},
            {-0.55f, 0.98f, -0.6f}},
           kit.material(Rgb{}, Rgb::grey(100)));
  kit.finish();
  const auto floor_flux = [&](double edge) {
    const Bench bench(kit, edge);
    SolverOptions options;
    options.rays = 256;
    options.direct_samples = 64;
    const auto solution = solve_stored_rays(bench.input, options, Progress{});
    EXPECT_TRUE(solution.ok());
    double flux = 0;
    for (ElementId e = 0; e < bench.elements.count(); ++e) {
      if (bench.elements.point(e, 0.5f, 0.5f).triangle > 1) continue;
      flux += static_cast<double>(solution->irradiance[e].g * bench.elements.area(e));
    }
    return flux;
  };
  const double fine = floor_flux(0.02), coarse = floor_flux(0.4);
  EXPECT_GT(fine, 0);
  EXPECT_NEAR(coarse, fine, 0.05 * fine);
}

/// Light that has to go a long way between white walls: corrections settle slowly, and are kept.
TEST(StoredRays, ReachTheEndOfACorridor) {
  SceneKit kit;
  kit.box({0, 0, 0}, {1, 1, 12}, kit.material(Rgb::grey(0.95f)));
  kit.quad(
      {Vec3f{0.4f, 0.99f, 0.2f}, {0.6f, 0.99f, 0.2f}, {0.6f, 0.99f, 0.4f}, {0.4f, 0.99f, 0.4f}},
      kit.material(Rgb::grey(0.5f), Rgb::grey(100)));
  kit.finish();
  const Bench bench(kit, 0.5);
  const auto solve = [&](double tolerance) {
    SolverOptions options;
    options.rays = 64;
    options.tolerance = tolerance;
    auto solution = solve_stored_rays(bench.input, options, Progress{});
    EXPECT_TRUE(solution.ok());
    EXPECT_LT(solution->statistics.residual, tolerance);
    return std::move(*solution);
  };
  const Solution usual = solve(1e-4), exact = solve(1e-6);
  // Iteration alone takes ln(19e4) / -ln 0.95 = 237.
  EXPECT_LE(usual.statistics.iterations, 120);
  double off = 0, all = 0;
  for (ElementId e = 0; e < bench.elements.count(); ++e) {
    const auto area = static_cast<double>(bench.elements.area(e));
    off += area * static_cast<double>(std::fabs(usual.irradiance[e].g - exact.irradiance[e].g));
    all += area * static_cast<double>(exact.irradiance[e].g);
  }
  // 1 / (1 - rho) times the tolerance.
  EXPECT_LT(off, 20 * 1e-4 * all);
}

/// White cards with holes, or glassy in parts, in an even sky: what they send back is what they
/// hide, so that all is as bright as the sky, wherever rays went.
TEST(StoredRays, HolesNeitherSwallowNorMakeLight) {
  for (const scene::AlphaMode mode : {scene::AlphaMode::kMask, scene::AlphaMode::kBlend}) {
    SceneKit kit;
    scene::Material leaf;
    leaf.base_color = Rgb::grey(1);
    leaf.metallic = 0;
    leaf.double_sided = true;
    leaf.alpha_mode = mode;
    const std::uint32_t material = kit.material(leaf);
    Random random(11);
    constexpr int kCards = 400;
    for (int i = 0; i < kCards; ++i) {
      const auto anywhere = [&] { return 2 * random.next_float() - 1; };
      const Vec3f at{anywhere(), anywhere(), anywhere()};
      const Vec3f u{0.3f * anywhere(), 0.3f * anywhere(), 0.3f * anywhere()};
      const Vec3f v{0.3f * anywhere(), 0.3f * anywhere(), 0.3f * anywhere()};
      kit.quad({at, at + u, at + u + v, at + v}, material);
      for (const float alpha : {0.0f, 0.3f, 1.0f, 0.7f}) {
        kit.scene().colors.push_back({{1, 1, 1}, alpha});
      }
    }
    kit.finish();
    const Bench bench(kit, 0.5, optics::Environment(Rgb::grey(1)));
    SolverOptions options;
    options.rays = 32;
    options.tolerance = 1e-6;
    const auto solution = solve_stored_rays(bench.input, options, Progress{});
    ASSERT_TRUE(solution.ok());
    // Reflectance is clamped to 0.999: a loss of up to a thousandth a bounce, of a few.
    for (ElementId e = 0; e < bench.elements.count(); ++e) {
      ASSERT_NEAR(solution->irradiance[e].g, kPi, 0.005f * kPi) << "element " << e;
    }
  }
}

}  // namespace
}  // namespace lightbatch::radiosity
