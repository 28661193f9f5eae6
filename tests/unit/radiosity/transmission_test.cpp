#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/accuracy/path_tracer.h"
#include "core/radiosity/linked_solver.h"
#include "tests/unit/radiosity/bench.h"

namespace lightbatch::radiosity {
namespace {

using accuracy::SceneKit;

/// A closed box of 2 x 1 x 1 m with a sheet across its middle that reflects 0.3 and lets 0.5
/// through diffusely (0.3 = 0.6 of what is not let through).
struct TwoChambers {
  SceneKit kit;
  std::uint32_t first_of_sheet = 0;

  /// nits: of the left chamber, of the right one, of the sheet.
  TwoChambers(float left, float right, float sheet) {
    scene::Material cloth;
    cloth.base_color = Rgb::grey(0.6f);
    cloth.metallic = 0;
    cloth.double_sided = true;
    cloth.emission = Rgb::grey(sheet);
    cloth.diffuse_transmission = 0.5f;
    const std::uint32_t here = kit.material(Rgb::grey(0.5f), Rgb::grey(left));
    const std::uint32_t there = kit.material(Rgb::grey(0.5f), Rgb::grey(right));
    half({0, 0, 0}, {1, 1, 1}, here, 5);
    half({1, 0, 0}, {2, 1, 1}, there, 4);
    const std::uint32_t material = kit.material(cloth);
    first_of_sheet = static_cast<std::uint32_t>(kit.scene().triangles.size());
    constexpr float kStep = 0.125f;
    for (int i = 0; i < 64; ++i) {
      const float y = kStep * static_cast<float>(i % 8), z = kStep * static_cast<float>(i / 8);
      kit.quad({Vec3f{1, y, z}, {1, y + kStep, z}, {1, y + kStep, z + kStep}, {1, y, z + kStep}},
               material);
    }
    kit.finish();
  }

  static Result<Solution> solve(const Bench& bench, bool linked) {
    SolverOptions options;
    options.rays = 1024;
    options.direct_samples = 32;
    options.tolerance = 1e-6;
    return linked ? solve_linked(bench.input, options, Progress{})
                  : solve_stored_rays(bench.input, options, Progress{});
  }

 private:
  /// Five faces of a box, inwards, without face number `open` of SceneKit::box.
  void half(const Vec3f& a, const Vec3f& b, std::uint32_t material, int open) {
    const std::array<std::array<Vec3f, 4>, 6> faces = {{
        {{{a.x, a.y, a.z}, {b.x, a.y, a.z}, {b.x, b.y, a.z}, {a.x, b.y, a.z}}},
        {{{a.x, b.y, b.z}, {b.x, b.y, b.z}, {b.x, a.y, b.z}, {a.x, a.y, b.z}}},
        {{{a.x, a.y, b.z}, {b.x, a.y, b.z}, {b.x, a.y, a.z}, {a.x, a.y, a.z}}},
        {{{a.x, b.y, a.z}, {b.x, b.y, a.z}, {b.x, b.y, b.z}, {a.x, b.y, b.z}}},
        {{{a.x, a.y, a.z}, {a.x, b.y, a.z}, {a.x, b.y, b.z}, {a.x, a.y, b.z}}},
        {{{b.x, a.y, b.z}, {b.x, b.y, b.z}, {b.x, b.y, a.z}, {b.x, a.y, a.z}}},
    }};
    for (int f = 0; f < 6; ++f) {
      if (f != open) kit.quad(faces[static_cast<std::size_t>(f)], material);
    }
  }
};

double mean_irradiance(const Elements& elements, const Solution& s) {
  double sum = 0, area = 0;
  for (ElementId e = 0; e < elements.count(); ++e) {
    sum += static_cast<double>(s.irradiance[e].g) * static_cast<double>(elements.area(e));
    area += static_cast<double>(elements.area(e));
  }
  return sum / area;
}

// Walls of 50 nits that reflect a half and a sheet of 20 nits that sends back 0.3 + 0.5 have one
// luminance, 100 nits: E = 100 pi everywhere. Elements of 0.2 m are groups of the sheet's
// triangles, of 0.1 m cells of each.
TEST(DiffuseTransmission, AFurnaceWithASheet) {
  const TwoChambers scene(50, 50, 20);
  const double exact = 100 * std::numbers::pi;
  for (const double edge : {0.2, 0.1}) {
    const Bench bench(scene.kit, edge);
    for (const bool linked : {false, true}) {
      const auto solution = TwoChambers::solve(bench, linked);
      ASSERT_TRUE(solution.ok());
      EXPECT_NEAR(mean_irradiance(bench.elements, *solution) / exact, 1, 0.01) << edge << linked;
      // Nothing is lost between the sides; links are normalised row by row.
      const double balance = solution->statistics.absorbed.g / solution->statistics.emitted.g;
      EXPECT_NEAR(balance, 1, linked ? 0.01 : 0.001) << edge << linked;
    }
  }
  const optics::Environment dark;
  const accuracy::PathTracer tracer(scene.kit.caster(), scene.kit.optics(), dark);
  const accuracy::SurfacePoint points[] = {{scene.first_of_sheet, 0.3f, 0.3f, false},
                                           {scene.first_of_sheet, 0.3f, 0.3f, true}};
  for (const auto& point : points) {
    const auto sum = tracer.irradiance(std::span(&point, 1), 20'000, 7);
    EXPECT_NEAR(sum.irradiance.g / exact, 1, 0.01);
  }
}

// One chamber lit, the other dark but for what comes through: the elements against path tracing.
TEST(DiffuseTransmission, ADarkRoomBehindACurtain) {
  const TwoChambers scene(100, 0, 0);
  const Bench bench(scene.kit, 0.1);
  const auto solution = TwoChambers::solve(bench, false);
  ASSERT_TRUE(solution.ok());
  const optics::Environment dark;
  const accuracy::PathTracer tracer(scene.kit.caster(), scene.kit.optics(), dark);
  for (const std::uint32_t triangle : {0u, scene.first_of_sheet - 2}) {  // left, right
    double elements = 0, truth = 0;
    for (const float u : {0.15f, 0.35f, 0.55f}) {
      const ElementId e = bench.elements.at(triangle, u, 0.25f, false);
      std::vector<accuracy::SurfacePoint> points;
      for (int k = 0; k < 16; ++k) {
        const auto p = bench.elements.point(e, (static_cast<float>(k % 4) + 0.5f) / 4,
                                            (static_cast<float>(k / 4) + 0.5f) / 4);
        points.push_back({p.triangle, p.u, p.v, false});
      }
      elements += static_cast<double>(solution->irradiance[e].g);
      truth += tracer.irradiance(points, 40'000, 3).irradiance.g;
    }
    EXPECT_GT(truth, 1);
    EXPECT_NEAR(elements / truth, 1, 0.02) << triangle;
  }
}

}  // namespace
}  // namespace lightbatch::radiosity
