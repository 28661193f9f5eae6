#include "core/atlas/texels.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "tests/unit/atlas/build_scene.h"
#include "tests/unit/atlas/check_layout.h"

namespace lightbatch::atlas {
namespace {

/// A layout by hand: every triangle in one chart on one page, at the given coordinates.
Layout by_hand(const std::vector<std::array<Vec2f, 3>>& uv, int size) {
  Layout layout;
  layout.pages = {{size, size}};
  Chart chart;
  chart.width = chart.height = size;
  chart.triangle_count = static_cast<std::uint32_t>(uv.size());
  layout.charts = {chart};
  layout.chart_of.assign(uv.size(), 0);
  layout.uv = uv;
  return layout;
}

scene::Scene triangles_of_area(std::size_t count, double area) {
  SceneBuilder b;
  b.begin_object();
  for (std::size_t i = 0; i < count; ++i) {
    const double z = static_cast<double>(i);
    const std::uint32_t p = b.add_point({0, 0, z}), q = b.add_point({2 * area, 0, z}),
                        r = b.add_point({0, 1, z});
    b.add_triangle(p, q, r);
  }
  return b.scene;
}

TEST(CoverTexels, HalfTexelTriangle) {
  const scene::Scene scene = triangles_of_area(1, 3.0);
  const TexelMap map = cover_texels(scene, by_hand({{{{2, 1}, {3, 1}, {2, 2}}}}, 8));
  ASSERT_EQ(map.texels.size(), 1u);
  const Texel& t = map.texels[0];
  EXPECT_EQ(t.x, 2);
  EXPECT_EQ(t.y, 1);
  ASSERT_EQ(t.fragment_count, 1u);
  const Fragment& f = map.fragments[0];
  EXPECT_FLOAT_EQ(f.area, 0.5f);
  EXPECT_FLOAT_EQ(f.surface, 3.0f);
  EXPECT_FLOAT_EQ(f.centroid.x, 2 + 1 / 3.0f);
  EXPECT_FLOAT_EQ(f.centroid.y, 1 + 1 / 3.0f);
  EXPECT_FLOAT_EQ(t.coverage, 0.5f);
  // Samples strictly below the diagonal: 3 + 2 + 1; those on it belong to one side only.
  const int count = std::popcount(static_cast<unsigned>(f.mask));
  EXPECT_TRUE(count == 6 || count == 10) << count;
}

TEST(CoverTexels, FansPartitionSamplesExactly) {
  // 64 triangles about a point, out to a square's border: every sample belongs to exactly one.
  constexpr int kTriangles = 64;
  constexpr float kSize = 16;
  Random random(7);
  std::vector<Vec2f> border;
  for (int side = 0; side < 4; ++side) {
    for (int i = 0; i < kTriangles / 4; ++i) {
      const float s = kSize * static_cast<float>(i) / (kTriangles / 4.0f);
      border.push_back(side == 0   ? Vec2f{s, 0}
                       : side == 1 ? Vec2f{kSize, s}
                       : side == 2 ? Vec2f{kSize - s, kSize}
                                   : Vec2f{0, kSize - s});
    }
  }
  for (int round = 0; round < 20; ++round) {
    const auto place = [&] {  // layouts hold multiples of 1/2048
      return static_cast<float>(2048 + random.below(14 * 2048)) / 2048;
    };
    const Vec2f centre{place(), place()};
    std::vector<std::array<Vec2f, 3>> uv;
    for (std::size_t i = 0; i < kTriangles; ++i) {
      uv.push_back({centre, border[i], border[(i + 1) % kTriangles]});
    }
    const scene::Scene scene = triangles_of_area(kTriangles, 1.0);
    const Layout layout = by_hand(uv, 16);
    const TexelMap map = cover_texels(scene, layout);
    ASSERT_EQ(map.texels.size(), 256u);
    for (const Texel& t : map.texels) {
      unsigned seen = 0;
      double area = 0;
      for (const Fragment& f : map.fragments_of(t)) {
        EXPECT_EQ(seen & f.mask, 0u);
        seen |= f.mask;
        area += static_cast<double>(f.area);
      }
      EXPECT_EQ(seen, 0xffffu);
      EXPECT_NEAR(area, 1.0, 1e-6);
      EXPECT_NEAR(static_cast<double>(t.coverage), 1.0, 1e-6);
    }
    expect_covered(scene, layout);
  }
}

TEST(CoverTexels, CollapsedTrianglesShareTheirSurfaceOut) {
  // A line of 4 texels of a triangle whose middle corner is at its start: a linear fall.
  const scene::Scene scene = triangles_of_area(2, 8.0);
  const Layout layout = by_hand(
      {{{{2.5f, 1.0f}, {2.5f, 1.0f}, {2.5f, 5.0f}}}, {{{6.5f, 6.5f}, {6.5f, 6.5f}, {6.5f, 6.5f}}}},
      8);
  const TexelMap map = cover_texels(scene, layout);
  ASSERT_EQ(map.texels.size(), 5u);
  const double expected[5] = {8 * 7 / 16.0, 8 * 5 / 16.0, 8 * 3 / 16.0, 8 * 1 / 16.0, 8.0};
  for (std::size_t i = 0; i < 5; ++i) {
    const Fragment& f = map.fragments_of(map.texels[i])[0];
    EXPECT_EQ(f.mask, 0);
    EXPECT_EQ(f.area, kCollapsedArea);
    EXPECT_NEAR(static_cast<double>(f.surface), expected[i], 1e-6);
  }
  expect_covered(scene, layout);
}

TEST(CoverTexels, SameBytesOnAnyNumberOfThreads) {
  SceneBuilder b;
  b.begin_object();
  b.add_torus(2, 0.7, 60, 30);
  LayoutOptions options;
  options.texels_per_metre = 40;
  const Layout layout = *make_layout(b.scene, b.all_lit(), options, Progress());
  const int before = thread_count();
  set_thread_count(1);
  const TexelMap one = cover_texels(b.scene, layout);
  set_thread_count(2);
  const TexelMap two = cover_texels(b.scene, layout);
  set_thread_count(before);
  ASSERT_EQ(one.texels.size(), two.texels.size());
  ASSERT_EQ(one.fragments.size(), two.fragments.size());
  for (std::size_t i = 0; i < one.fragments.size(); ++i) {
    const Fragment &f = one.fragments[i], &g = two.fragments[i];
    ASSERT_TRUE(f.triangle == g.triangle && f.mask == g.mask && f.area == g.area &&
                f.centroid == g.centroid && f.surface == g.surface);
  }
  EXPECT_EQ(one.index, two.index);
}

TEST(PointAt, InvertsTheMap) {
  SceneBuilder b;
  b.begin_object();
  b.add_sphere({0, 0, 0}, 1, 24, 12);
  LayoutOptions options;
  options.texels_per_metre = 50;
  const Layout layout = *make_layout(b.scene, b.all_lit(), options, Progress());
  Random random(3);
  for (std::uint32_t t = 0; t < b.scene.triangles.size(); ++t) {
    if (layout.chart_of[t] == scene::kNone || uv_area(layout, t) < 0.01) continue;
    float u = random.next_float(), v = random.next_float();
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    const auto& c = layout.uv[t];
    const Vec2f p = c[0] * (1 - u - v) + c[1] * u + c[2] * v;
    const SurfacePoint point = point_at(layout, t, p);
    // Page coordinates are rounded to 2^-15 texel here; triangles are about a texel large.
    EXPECT_NEAR(point.u, u, 5e-3);
    EXPECT_NEAR(point.v, v, 5e-3);
  }
}

TEST(PointAt, StaysInsideTheTriangle) {
  const Layout layout = by_hand({{{{1, 1}, {4, 1}, {1, 3}}},
                                 {{{1.5f, 1.5f}, {1.5f, 6.5f}, {1.5f, 3.5f}}},
                                 {{{2.5f, 2.5f}, {2.5f, 2.5f}, {2.5f, 2.5f}}}},
                                8);
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const Vec2f p{8 * random.next_float() - 1, 8 * random.next_float() - 1};
    for (std::uint32_t t = 0; t < 3; ++t) {
      const SurfacePoint s = point_at(layout, t, p);
      EXPECT_EQ(s.triangle, t);
      EXPECT_GE(s.u, 0.0f);
      EXPECT_GE(s.v, 0.0f);
      EXPECT_LE(s.u + s.v, 1.000001f);
    }
  }
  // On a line, the point maps back to the line's place.
  for (const float y : {1.5f, 2.0f, 3.5f, 5.0f, 6.5f}) {
    const SurfacePoint s = point_at(layout, 1, {1.5f, y});
    EXPECT_NEAR((1 - s.u - s.v) * 1.5f + s.u * 6.5f + s.v * 3.5f, y, 1e-5f);
  }
}

}  // namespace
}  // namespace lightbatch::atlas
