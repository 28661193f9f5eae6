#include "core/atlas/layout.h"

#include <gtest/gtest.h>

#include <cstring>

#include "core/base/parallel.h"
#include "tests/unit/atlas/build_scene.h"
#include "tests/unit/atlas/check_layout.h"

namespace lightbatch::atlas {
namespace {

Layout lay_out(const scene::Scene& scene, const std::vector<std::uint8_t>& lit,
               const LayoutOptions& options = {}) {
  auto layout = make_layout(scene, lit, options, Progress());
  EXPECT_TRUE(layout.ok()) << layout.status().to_string();
  return std::move(layout).value();
}

LayoutOptions at_density(double texels_per_metre) {
  LayoutOptions options;
  options.texels_per_metre = texels_per_metre;
  return options;
}

double world_length(const scene::Scene& scene, std::size_t t, std::size_t k) {
  const auto c = scene.corners(static_cast<std::uint32_t>(t));
  return length(to_double(c[(k + 1) % 3]) - to_double(c[k]));
}

double uv_length(const Layout& layout, std::size_t t, std::size_t k) {
  const Vec2f d = layout.uv[t][(k + 1) % 3] - layout.uv[t][k];
  return std::hypot(static_cast<double>(d.x), static_cast<double>(d.y));
}

TEST(Layout, OneQuadIsOneTightPage) {
  SceneBuilder b;
  b.begin_object();
  b.add_quad({0, 0, 0}, {3, 0, 0}, {0, 2, 0});
  const Layout layout = lay_out(b.scene, b.all_lit(), at_density(10));
  expect_sound(b.scene, b.all_lit(), layout);
  expect_covered(b.scene, layout);
  ASSERT_EQ(layout.charts.size(), 1u);
  ASSERT_EQ(layout.pages.size(), 1u);
  // (30 + 1) x (20 + 1) texels, rounded up to multiples of 4.
  EXPECT_LE(layout.pages[0].width * layout.pages[0].height, 32 * 24);
  EXPECT_DOUBLE_EQ(layout.texels_per_metre, 10);
  EXPECT_NEAR(layout.charted_area, 6, 1e-12);
  // 10 texels a metre exactly: every edge, to the grid of 1/2048 texel.
  for (std::size_t t = 0; t < 2; ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(uv_length(layout, t, k), 10 * world_length(b.scene, t, k), 1e-3);
    }
  }
  EXPECT_EQ(layout.out_of_density_area, 0);
}

TEST(Layout, DefaultDensityFillsTheAskedTexels) {
  SceneBuilder b;
  b.begin_object();
  b.add_quad({0, 0, 0}, {3, 0, 0}, {0, 3, 0});
  LayoutOptions options;
  options.default_texels = 10000;
  const Layout layout = lay_out(b.scene, b.all_lit(), options);
  ASSERT_EQ(layout.pages.size(), 1u);
  EXPECT_NEAR(layout.pages[0].width * layout.pages[0].height, 10000, 1000);
  EXPECT_EQ(layout.asked_texels_per_metre, 0);
  EXPECT_NEAR(layout.texels_per_metre, 100 / 3.0, 2);
}

TEST(Layout, FlatWallOfManyTrianglesIsOneUndistortedChart) {
  SceneBuilder b;
  const Affine turned = Affine::from_trs({4, 5, 6}, {0.1, 0.2, 0.3, 0.9}, {1, 1, 1});
  b.begin_object(turned);
  b.add_patch(17, 9, [](double u, double v) { return Vec3d{6.013 * u, 3.007 * v * v, 0}; });
  const Layout layout = lay_out(b.scene, b.all_lit(), at_density(20));
  expect_sound(b.scene, b.all_lit(), layout);
  ASSERT_EQ(layout.charts.size(), 1u);
  for (std::size_t t = 0; t < b.scene.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      // Snapping stretches 120.26 to 120 and 60.14 to 60 texels: 0.25 %.
      EXPECT_NEAR(uv_length(layout, t, k), 20 * world_length(b.scene, t, k),
                  0.003 * 20 * world_length(b.scene, t, k) + 1e-3);
    }
  }
  // No seams inside: shared points have one coordinate.
  std::vector<Vec2f> of_point(b.scene.positions.size(), Vec2f{-1, -1});
  for (std::size_t t = 0; t < b.scene.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      Vec2f& p = of_point[b.scene.triangles[t].vertex[k]];
      if (p == Vec2f{-1, -1}) p = layout.uv[t][k];
      EXPECT_TRUE(p == layout.uv[t][k]);
    }
  }
}

TEST(Layout, BoxHasSixCharts) {
  SceneBuilder b;
  b.begin_object();
  b.add_box({0, 0, 0}, {1, 2, 3});
  const Layout layout = lay_out(b.scene, b.all_lit(), at_density(16));
  expect_sound(b.scene, b.all_lit(), layout);
  expect_covered(b.scene, layout);
  EXPECT_EQ(layout.charts.size(), 6u);
  EXPECT_NEAR(layout.charted_area, 22, 1e-12);
}

TEST(Layout, CurvedSurfacesKeepTheDensity) {
  SceneBuilder b;
  b.begin_object();
  b.add_sphere({0, 0, 0}, 1, 64, 32);
  b.begin_object();
  b.add_torus(2, 0.5, 96, 48);
  const Layout layout = lay_out(b.scene, b.all_lit(), at_density(30));
  expect_sound(b.scene, b.all_lit(), layout);
  expect_covered(b.scene, layout);
  EXPECT_LE(layout.out_of_density_area, 0.001);
  EXPECT_GE(layout.charts.size(), 10u);
  EXPECT_LE(layout.charts.size(), 80u);
  EXPECT_GE(layout.utilisation, 0.5);
}

TEST(Layout, ClosedRibbonAndSpiralNeverLieOnThemselves) {
  SceneBuilder b;
  // Two turns of a ramp seen from above: normals fit one cone, the second turn hides the first.
  b.begin_object();
  b.add_patch(200, 4, [](double u, double v) {
    const double a = 4 * std::numbers::pi * u, r = 1 + v;
    return Vec3d{r * std::cos(a), r * std::sin(a), 0.5 * a};
  });
  const Layout layout = lay_out(b.scene, b.all_lit(), at_density(20));
  expect_sound(b.scene, b.all_lit(), layout);
  EXPECT_GE(layout.charts.size(), 2u);
  // Overlap would make fragments of one texel share samples.
  expect_covered(b.scene, layout);
}

TEST(Layout, SeveralPages) {
  SceneBuilder b;
  for (int i = 0; i < 12; ++i) {
    b.begin_object();
    b.add_quad({0, 0, 1.0 * i}, {5, 0, 0}, {0, 4, 0});
  }
  LayoutOptions options = at_density(10);
  options.page_size = 64;
  const Layout layout = lay_out(b.scene, b.all_lit(), options);
  expect_sound(b.scene, b.all_lit(), layout);
  EXPECT_GE(layout.pages.size(), 6u);
  EXPECT_LE(layout.pages.size(), 12u);
  for (const Page& p : layout.pages) {
    EXPECT_LE(p.width, 64);
    EXPECT_LE(p.height, 64);
  }
}

TEST(Layout, LimitLowersTheDensityAndSaysSo) {
  SceneBuilder b;
  b.begin_object();
  b.add_box({0, 0, 0}, {10, 10, 10});
  LayoutOptions options = at_density(100);
  options.max_texels = 50000;
  const Layout layout = lay_out(b.scene, b.all_lit(), options);
  expect_sound(b.scene, b.all_lit(), layout);
  EXPECT_EQ(layout.asked_texels_per_metre, 100);
  EXPECT_LT(layout.texels_per_metre, 10);
  EXPECT_GT(layout.texels_per_metre, 6);
  double texels = 0;
  for (const Page& p : layout.pages) texels += p.width * p.height;
  EXPECT_LE(texels, 50000);
}

TEST(Layout, LitTrianglesOnly) {
  SceneBuilder b;
  b.begin_object();
  b.add_box({0, 0, 0}, {1, 1, 1});
  std::vector<std::uint8_t> lit(12, 0);
  EXPECT_TRUE(lay_out(b.scene, lit).pages.empty());
  lit[2] = lit[3] = 1;
  const Layout layout = lay_out(b.scene, lit, at_density(10));
  expect_sound(b.scene, lit, layout);
  EXPECT_EQ(layout.charts.size(), 1u);
}

TEST(Layout, InstancesShareOneBlock) {
  SceneBuilder b;
  const auto add = [&](const Affine& m) {
    b.begin_object(m, 7);
    b.add_torus(1, 0.3, 32, 16);
    b.add_box({0, 0, 1}, {0.5, 0.25, 0.75});
  };
  add({});
  add(Affine::from_trs({10, 0, 0}, {0, 0.6, 0, 0.8}, {1, 1, 1}));
  add(Affine::from_trs({0, 10, 0}, {0.5, 0.5, 0.5, 0.5}, {-1, 1, 1}));
  add(Affine::from_trs({0, 0, 10}, {0, 0, 0, 1}, {2, 2, 2}));
  add(Affine::from_trs({0, 0, -10}, {0, 0, 0, 1}, {1, 2, 1}));
  const Layout layout = lay_out(b.scene, b.all_lit(), at_density(20));
  expect_sound(b.scene, b.all_lit(), layout);
  expect_covered(b.scene, layout);
  const std::size_t n = b.scene.triangles.size() / 5;
  // Rigid and mirrored copies: the same distances, so the same shape in the atlas.
  for (std::size_t copy = 1; copy <= 2; ++copy) {
    for (std::size_t t = 0; t < n; ++t) {
      EXPECT_EQ(uv_area(layout, t), uv_area(layout, copy * n + t));
    }
  }
  EXPECT_LE(layout.out_of_density_area, 0.001);
}

TEST(Layout, SameBytesOnAnyNumberOfThreads) {
  SceneBuilder b;
  for (int i = 0; i < 20; ++i) {
    b.begin_object(Affine::from_trs({3.0 * i, 0, 0}, {0, 0, 0.1 * i, 1}, {1, 1, 1}));
    b.add_torus(1, 0.05 + 0.02 * i, 24, 12);
  }
  const int before = thread_count();
  std::vector<Layout> layouts;
  for (const int threads : {1, 2, 3}) {
    set_thread_count(threads);
    layouts.push_back(lay_out(b.scene, b.all_lit(), at_density(25)));
  }
  set_thread_count(before);
  for (std::size_t i = 1; i < layouts.size(); ++i) {
    ASSERT_EQ(layouts[0].chart_of, layouts[i].chart_of);
    EXPECT_EQ(std::memcmp(layouts[0].uv.data(), layouts[i].uv.data(),
                          layouts[0].uv.size() * sizeof(layouts[0].uv[0])),
              0);
    EXPECT_EQ(layouts[0].utilisation, layouts[i].utilisation);
    EXPECT_EQ(layouts[0].out_of_density_area, layouts[i].out_of_density_area);
  }
}

TEST(Layout, CancelsAndRefusesBadOptions) {
  SceneBuilder b;
  b.begin_object();
  b.add_box({0, 0, 0}, {1, 1, 1});
  std::atomic<bool> stop{true};
  EXPECT_EQ(make_layout(b.scene, b.all_lit(), {}, Progress({}, &stop)).status().reason(),
            "CANCELLED");
  for (const double density : {-1.0, std::nan(""), 1.0 / 0.0}) {
    EXPECT_EQ(make_layout(b.scene, b.all_lit(), at_density(density), Progress()).status().reason(),
              "BAD_OPTION");
  }
  LayoutOptions options;
  options.page_size = 32;
  EXPECT_EQ(make_layout(b.scene, b.all_lit(), options, Progress()).status().reason(), "BAD_OPTION");
}

}  // namespace
}  // namespace lightbatch::atlas
