#include <gtest/gtest.h>

#include <ctime>
#include <set>

#include "core/atlas/layout.h"
#include "core/base/random.h"
#include "tests/unit/atlas/build_scene.h"
#include "tests/unit/atlas/check_layout.h"

namespace lightbatch::atlas {
namespace {

Layout lay_out(const scene::Scene& scene, double density, int page_size = 2048) {
  LayoutOptions options;
  options.texels_per_metre = density;
  options.page_size = page_size;
  const std::vector<std::uint8_t> lit(scene.triangles.size(), 1);
  auto layout = make_layout(scene, lit, options, Progress());
  EXPECT_TRUE(layout.ok()) << layout.status().to_string();
  expect_sound(scene, lit, *layout);
  expect_covered(scene, *layout);
  return std::move(layout).value();
}

TEST(HostileScenes, NothingToLayOut) {
  const Layout empty = lay_out(scene::Scene(), 10);
  EXPECT_TRUE(empty.pages.empty());
  SceneBuilder b;
  b.begin_object();
  const std::uint32_t p = b.add_point({1, 2, 3}), q = b.add_point({2, 4, 6}),
                      r = b.add_point({3, 6, 9});
  b.add_triangle(p, p, p);
  b.add_triangle(p, q, q);
  b.add_triangle(p, q, r);
  const Layout layout = lay_out(b.scene, 0);
  EXPECT_TRUE(layout.pages.empty());
  EXPECT_TRUE(layout.charts.empty());
  EXPECT_EQ(layout.utilisation, 0);
}

TEST(HostileScenes, OneHugeAmongManyTiny) {
  SceneBuilder b;
  b.begin_object();
  b.add_quad({-5e4, -5e4, 0}, {1e5, 0, 0}, {0, 1e5, 0});
  Random random(1);
  for (int i = 0; i < 3000; ++i) {
    b.begin_object();
    b.add_box({100 * random.next_double(), 100 * random.next_double(), 1},
              {0.01 + random.next_double(), 0.01 + random.next_double(), 0.1});
  }
  const Layout layout = lay_out(b.scene, 20, 1024);
  // The field is squeezed to a page, and says so; the boxes keep the density.
  EXPECT_EQ(layout.texels_per_metre, 20);
  EXPECT_GT(layout.out_of_density_area, 0.9);
  const Layout automatic = lay_out(b.scene, 0, 1024);
  double texels = 0;
  for (const Page& p : automatic.pages) texels += p.width * p.height;
  EXPECT_LE(texels, 1.1 * LayoutOptions{}.default_texels);
}

TEST(HostileScenes, NonManifoldFans) {
  SceneBuilder b;
  b.begin_object();
  const std::uint32_t p = b.add_point({0, 0, 0}), q = b.add_point({0, 0, 1});
  Random random(2);
  for (int i = 0; i < 20000; ++i) {  // one edge of 20,000 triangles, then edges of few
    const double a = 2 * std::numbers::pi * random.next_double();
    const std::uint32_t r = b.add_point({std::cos(a), std::sin(a), random.next_double()});
    if (i % 2 == 0) {
      b.add_triangle(p, q, r);
    } else {
      b.add_triangle(q, p, r);
    }
  }
  for (int i = 0; i < 50; ++i) {
    const std::uint32_t s = b.add_point({3.0 * i, 5, 0}), t = b.add_point({3.0 * i, 5, 1});
    for (int k = 0; k < 5; ++k) {
      const std::uint32_t r = b.add_point({3.0 * i + std::cos(k), 5 + std::sin(k), 0.5});
      b.add_triangle(k % 2 == 0 ? s : t, k % 2 == 0 ? t : s, r);
    }
  }
  const Layout layout = lay_out(b.scene, 6);
  EXPECT_EQ(layout.out_of_density_area, 0);
}

TEST(HostileScenes, MoebiusStrip) {
  SceneBuilder b;
  b.begin_object();
  const int n = 120, m = 6;
  std::vector<std::uint32_t> ring;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= m; ++j) {
      const double a = 2 * std::numbers::pi * i / n, w = static_cast<double>(j) / m - 0.5;
      const double r = 2 + w * std::cos(a / 2);
      ring.push_back(b.add_point({r * std::cos(a), r * std::sin(a), w * std::sin(a / 2)}));
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < m; ++j) {
      const auto at = [&](int row, int column) {  // the last row meets the first one upside down
        const bool wraps = row == n;
        return ring[static_cast<std::size_t>((wraps ? 0 : row) * (m + 1) +
                                             (wraps ? m - column : column))];
      };
      b.add_triangle(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      b.add_triangle(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  const Layout layout = lay_out(b.scene, 25);
  EXPECT_LE(layout.out_of_density_area, 0.001);
  EXPECT_LE(layout.charts.size(), 40u);
}

TEST(HostileScenes, CoincidentFrontAndBackAreTwoCharts) {
  SceneBuilder b;
  b.begin_object();
  const std::uint32_t p = b.add_point({0, 0, 0}), q = b.add_point({1, 0, 0}),
                      r = b.add_point({1, 1, 0}), s = b.add_point({0, 1, 0});
  b.add_triangle(p, q, r);
  b.add_triangle(p, r, s);
  b.add_triangle(p, r, q);
  b.add_triangle(p, s, r);
  const Layout layout = lay_out(b.scene, 16);
  ASSERT_EQ(layout.charts.size(), 2u);
  EXPECT_EQ(layout.chart_of[0], layout.chart_of[1]);
  EXPECT_EQ(layout.chart_of[2], layout.chart_of[3]);
  EXPECT_NE(layout.chart_of[0], layout.chart_of[2]);
}

TEST(HostileScenes, RepeatedTrianglesDoNotShareTexels) {
  SceneBuilder b;
  b.begin_object();
  const std::uint32_t p = b.add_point({0, 0, 0}), q = b.add_point({1, 0, 0}),
                      r = b.add_point({1, 1, 0});
  for (int i = 0; i < 40; ++i) b.add_triangle(p, q, r);
  const Layout layout = lay_out(b.scene, 16);
  EXPECT_EQ(layout.charts.size(), 40u);
}

TEST(HostileScenes, HundredThousandLooseTriangles) {
  SceneBuilder b;
  b.begin_object();
  Random random(4);
  for (int i = 0; i < 100000; ++i) {
    const Vec3d o{50 * random.next_double(), 50 * random.next_double(), 50 * random.next_double()};
    const auto near = [&] {
      return b.add_point(
          o + Vec3d{random.next_double(), random.next_double(), random.next_double()} * 0.3);
    };
    const std::uint32_t p = near(), q = near(), r = near();
    b.add_triangle(p, q, r);
  }
  const std::clock_t start = std::clock();
  const Layout layout = lay_out(b.scene, 0);
  // Measured 1 s with the brute-force checks; a quadratic step would take minutes.
  EXPECT_LE(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 30.0);
  EXPECT_GE(layout.charts.size(), 1000u);
}

TEST(HostileScenes, AnyUnitOfLength) {
  for (const double unit : {1e-3, 1.0, 1e3, 1.2e5}) {
    SceneBuilder b;
    b.begin_object();
    b.add_box({0, 0, 0}, {unit, unit, unit});
    b.begin_object();
    b.add_sphere({unit / 2, unit / 2, unit / 2}, unit / 4, 48, 24);
    const Layout layout = lay_out(b.scene, 0);
    ASSERT_EQ(layout.pages.size(), 1u);
    const double texels = layout.pages[0].width * layout.pages[0].height;
    EXPECT_NEAR(texels, LayoutOptions{}.default_texels, 0.1 * LayoutOptions{}.default_texels);
    EXPECT_LE(layout.out_of_density_area, 0.001);
    // The same scene in other units: the same charts.
    EXPECT_NEAR(static_cast<double>(layout.charts.size()), 18, 12);
  }
}

TEST(HostileScenes, SliversFollowTheirNeighbours) {
  // A wall with a seam of needles: one chart all the same.
  SceneBuilder b;
  b.begin_object();
  const double h = 1e-7;
  std::vector<std::uint32_t> low, high;
  for (int i = 0; i <= 10; ++i) {
    low.push_back(b.add_point({0.1 * i, 0.5, (i % 2) * h}));
    high.push_back(b.add_point({0.1 * i, 0.5 + h, 0}));
  }
  const std::uint32_t p = b.add_point({0, 0, 0}), q = b.add_point({1, 0, 0}),
                      r = b.add_point({1, 1, 0}), s = b.add_point({0, 1, 0});
  for (std::size_t i = 0; i < 10; ++i) {
    b.add_triangle(low[i], low[i + 1], high[i + 1]);
    b.add_triangle(low[i], high[i + 1], high[i]);
    b.add_triangle(p, low[i + 1], low[i]);
    b.add_triangle(s, high[i], high[i + 1]);
  }
  b.add_triangle(p, q, low[10]);
  b.add_triangle(s, high[10], r);
  const Layout layout = lay_out(b.scene, 40);
  EXPECT_EQ(layout.charts.size(), 1u);
}

TEST(HostileScenes, ImpossibleBudgetIsAnError) {
  SceneBuilder b;
  for (int i = 0; i < 500; ++i) {
    b.begin_object();
    b.add_quad({0, 0, 1.0 * i}, {1, 0, 0}, {0, 1, 0});
  }
  LayoutOptions options;
  options.max_texels = 100;  // each object needs a texel
  const auto layout = make_layout(b.scene, b.all_lit(), options, Progress());
  EXPECT_EQ(layout.status().reason(), "INPUT_OVER_BUDGET");
  options.max_texels = 3000;
  EXPECT_TRUE(make_layout(b.scene, b.all_lit(), options, Progress()).ok());
}

TEST(HostileScenes, SpiralOfManyTurnsEnds) {
  SceneBuilder b;
  b.begin_object();
  b.add_patch(4000, 1, [](double u, double v) {
    const double a = 200 * 2 * std::numbers::pi * u, r = 1 + v;
    return Vec3d{r * std::cos(a), r * std::sin(a), 0.02 * a};
  });
  const std::clock_t start = std::clock();
  const Layout layout = lay_out(b.scene, 30);
  EXPECT_LE(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 20.0);
  EXPECT_GE(layout.charts.size(), 200u);  // one turn at most fits a chart
}

}  // namespace
}  // namespace lightbatch::atlas
