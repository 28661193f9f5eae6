#include "core/lightmap/punctual_texel.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "tests/unit/lightmap/lit_scene.h"

namespace lightbatch::lightmap {
namespace {

/// Black leaves of one object, of any directions, in a sun that each other and a lattice of laths
/// lets through in places.
LitScene leaves(float size, double texels_per_metre) {
  LitScene lit;
  auto& kit = lit.kit;
  const std::uint32_t black = kit.material(Rgb{});
  Random random(3);
  const auto unit = [&] { return 2 * random.next_float() - 1; };
  for (int k = 0; k < 300; ++k) {
    const Vec3f at{unit(), 0.5f * unit(), unit()};
    const Vec3f normal = normalized(Vec3f{unit(), unit() + 1, unit()});
    const Frame frame = Frame::about(normal);
    const Vec3f a = frame.x * size, b = frame.y * size;
    kit.quad({at - a - b, at + a - b, at + a + b, at - a + b}, black);
  }
  scene::Scene& scene = kit.scene();
  const auto count = static_cast<std::uint32_t>(scene.triangles.size());
  for (std::uint32_t t = 0; t < count; ++t) {
    scene.triangles[t].object = 0;
    scene.triangles[t].source = t;
  }
  scene.objects.resize(1);
  scene.objects[0].triangle_count = count;
  for (int k = 0; k < 30; ++k) {
    const float x = -1.5f + 0.1f * static_cast<float>(k);
    kit.quad({Vec3f{x, 1, 2}, {x + 0.06f, 1, 2}, {x + 0.06f, 1, -2}, {x, 1, -2}}, black);
  }
  scene::Light sun;
  sun.kind = scene::LightKind::kDirectional;
  sun.direction = to_double(normalized(Vec3f{0.3f, -0.9f, 0.2f}));
  sun.intensity = {1000, 1000, 1000};
  scene.lights.push_back(sun);
  lit.chart(texels_per_metre);
  lit.solve();
  return lit;
}

/// Root of the mean square that the direct light of the leaves' texels is off, over its mean.
double error_of(const LitScene& lit) {
  GatherSettings settings;
  settings.direct_error = 0.03;
  BakeInput input = lit.input();
  BakeCounts counts;
  radiosity::GroupedLight none;
  const accuracy::PathTracer tracer(lit.kit.caster(), lit.kit.optics(), lit.sky);
  const std::uint32_t leaf_triangles = lit.kit.scene().objects[0].triangle_count;
  std::vector<std::uint32_t> leaf;
  std::vector<double> truth;
  double mean = 0;
  for (std::uint32_t t = 0; t < lit.texels.texels.size(); ++t) {
    const TexelPoints points = texel_points(lit.texels, lit.texels.texels[t]);
    if (points.point[0].triangle >= leaf_triangles) continue;
    const accuracy::PointSource source = [&](float which, Vec2f within) {
      const auto i = static_cast<std::uint32_t>(which * static_cast<float>(points.count));
      const auto p = surface_point(lit.layout, points.point[std::min(i, points.count - 1)], within);
      return accuracy::SurfacePoint{p.triangle, p.u, p.v, false};
    };
    leaf.push_back(t);
    truth.push_back(tracer.irradiance(source, 4096, t).irradiance.g);
    mean += truth.back();
  }
  mean /= static_cast<double>(truth.size());
  input.mean_irradiance = mean;
  const DimShares dim(input, settings);
  const auto direct = bake_direct(input, settings, dim, none, counts, Progress{});
  double squares = 0;
  for (std::size_t k = 0; k < leaf.size(); ++k) {
    squares += std::pow(static_cast<double>(direct[leaf[k]].g) - truth[k], 2);
  }
  return std::sqrt(squares / static_cast<double>(leaf.size())) / mean;
}

// Texels of one or two samples: all of the texel is at an edge, not five of sixteen parts.
TEST(PunctualTexel, LeavesSmallerThanATexelHalfInTheSun) {
  EXPECT_LT(error_of(leaves(0.06f, 5)), 0.02);
}

// Texels that many leaves share: light is found where few of them have it.
TEST(PunctualTexel, ManyLeavesInATexel) { EXPECT_LT(error_of(leaves(0.03f, 2)), 0.05); }

}  // namespace
}  // namespace lightbatch::lightmap
