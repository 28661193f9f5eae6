#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/atlas/layout.h"
#include "core/atlas/texels.h"

namespace lightbatch::atlas {

inline double cross_z(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
  return (static_cast<double>(b.x) - static_cast<double>(a.x)) *
             (static_cast<double>(c.y) - static_cast<double>(a.y)) -
         (static_cast<double>(c.x) - static_cast<double>(a.x)) *
             (static_cast<double>(b.y) - static_cast<double>(a.y));
}

inline double uv_area(const Layout& layout, std::size_t t) {
  return std::abs(cross_z(layout.uv[t][0], layout.uv[t][1], layout.uv[t][2])) / 2;
}

/// Separating-axis test of a triangle and the open square of half width 1 about (x, y): whether a
/// bilinear lookup somewhere on the triangle reads the texel with that centre.
inline bool reads_texel(const std::array<Vec2f, 3>& uv, double x, double y) {
  Vec2d p[3];
  for (std::size_t k = 0; k < 3; ++k) {
    p[k] = {static_cast<double>(uv[k].x) - x, static_cast<double>(uv[k].y) - y};
  }
  const auto apart = [&](const Vec2d& axis) {
    const double reach = std::abs(axis.x) + std::abs(axis.y);
    double low = 1e300, high = -1e300;
    for (const Vec2d& q : p) {
      low = std::min(low, axis.x * q.x + axis.y * q.y);
      high = std::max(high, axis.x * q.x + axis.y * q.y);
    }
    return low >= reach || high <= -reach;
  };
  if (apart({1, 0}) || apart({0, 1})) return false;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec2d side = p[(k + 1) % 3] - p[k];
    if ((side.x != 0 || side.y != 0) && apart({-side.y, side.x})) return false;
  }
  return true;
}

/// Texels read by two charts, by brute force over every triangle and texel of its bounding box.
inline std::size_t brute_conflicts(const Layout& layout) {
  std::size_t conflicts = 0;
  std::vector<std::vector<std::uint32_t>> owner;
  for (const Page& p : layout.pages) {
    owner.emplace_back(static_cast<std::size_t>(p.width) * static_cast<std::size_t>(p.height),
                       scene::kNone);
  }
  for (std::size_t t = 0; t < layout.uv.size(); ++t) {
    const std::uint32_t chart = layout.chart_of[t];
    if (chart == scene::kNone) continue;
    const Page& page = layout.pages[layout.charts[chart].page];
    const auto& uv = layout.uv[t];
    const auto [x0, x1] = std::minmax({uv[0].x, uv[1].x, uv[2].x});
    const auto [y0, y1] = std::minmax({uv[0].y, uv[1].y, uv[2].y});
    for (int y = std::max(0, static_cast<int>(y0) - 2);
         y <= std::min(page.height - 1, static_cast<int>(y1) + 2); ++y) {
      for (int x = std::max(0, static_cast<int>(x0) - 2);
           x <= std::min(page.width - 1, static_cast<int>(x1) + 2); ++x) {
        if (!reads_texel(uv, x + 0.5, y + 0.5)) continue;
        auto& o = owner[layout.charts[chart].page][static_cast<std::size_t>(y * page.width + x)];
        if (o != scene::kNone && o != chart) ++conflicts;
        o = chart;
      }
    }
  }
  return conflicts;
}

/// What every layout must be.
inline void expect_sound(const scene::Scene& scene, const std::vector<std::uint8_t>& lit,
                         const Layout& layout) {
  ASSERT_EQ(layout.chart_of.size(), scene.triangles.size());
  ASSERT_EQ(layout.uv.size(), scene.triangles.size());
  std::vector<std::uint32_t> triangles(layout.charts.size(), 0);
  for (std::size_t t = 0; t < scene.triangles.size(); ++t) {
    const std::uint32_t c = layout.chart_of[t];
    if (lit[t] == 0) {
      EXPECT_EQ(c, scene::kNone);
    }
    if (c == scene::kNone) continue;
    ASSERT_LT(c, layout.charts.size());
    ++triangles[c];
    const Chart& chart = layout.charts[c];
    for (const Vec2f& p : layout.uv[t]) {
      ASSERT_GE(p.x, static_cast<float>(chart.x) + 0.5f);
      ASSERT_GE(p.y, static_cast<float>(chart.y) + 0.5f);
      ASSERT_LE(p.x, static_cast<float>(chart.x + chart.width) - 0.5f);
      ASSERT_LE(p.y, static_cast<float>(chart.y + chart.height) - 0.5f);
    }
  }
  for (std::size_t c = 0; c < layout.charts.size(); ++c) {
    const Chart& chart = layout.charts[c];
    ASSERT_LT(chart.page, layout.pages.size());
    EXPECT_EQ(chart.triangle_count, triangles[c]);
    EXPECT_GE(chart.x, 0);
    EXPECT_GE(chart.y, 0);
    EXPECT_LE(chart.x + chart.width, layout.pages[chart.page].width);
    EXPECT_LE(chart.y + chart.height, layout.pages[chart.page].height);
    EXPECT_NEAR(static_cast<double>(length(chart.normal)), 1.0, 1e-5);
  }
  EXPECT_EQ(layout.footprint_conflicts, 0u);
  EXPECT_EQ(brute_conflicts(layout), 0u);
}

inline double world_area(const scene::Scene& scene, std::size_t t) {
  const auto c = scene.corners(static_cast<std::uint32_t>(t));
  const Vec3d a = to_double(c[0]);
  return length(cross(to_double(c[1]) - a, to_double(c[2]) - a)) / 2;
}

/// Whatever the layout, coverage must add up, texel by texel and triangle by triangle.
inline void expect_covered(const scene::Scene& scene, const Layout& layout) {
  const TexelMap map = cover_texels(scene, layout);
  std::vector<double> area(scene.triangles.size(), 0.0), surface(scene.triangles.size(), 0.0);
  std::uint64_t last = 0;
  for (std::size_t i = 0; i < map.texels.size(); ++i) {
    const Texel& texel = map.texels[i];
    const std::uint64_t key =
        (std::uint64_t{texel.page} << 32 | std::uint64_t{texel.y} << 16 | texel.x) + 1;
    ASSERT_GT(key, last);
    last = key;
    const Page& page = layout.pages[texel.page];
    ASSERT_EQ(map.index[texel.page][static_cast<std::size_t>(texel.y * page.width + texel.x)], i);
    unsigned seen = 0;
    ASSERT_GT(texel.fragment_count, 0u);
    for (const Fragment& f : map.fragments_of(texel)) {
      EXPECT_EQ(layout.chart_of[f.triangle], texel.chart);
      EXPECT_EQ(seen & f.mask, 0u);
      seen |= f.mask;
      EXPECT_GT(f.area, 0.0f);
      EXPECT_GE(f.surface, 0.0f);
      // Float rounding of page coordinates: 2^-12 at 4096.
      EXPECT_GE(f.centroid.x, static_cast<float>(texel.x) - 3e-4f);
      EXPECT_LE(f.centroid.x, static_cast<float>(texel.x + 1) + 3e-4f);
      EXPECT_GE(f.centroid.y, static_cast<float>(texel.y) - 3e-4f);
      EXPECT_LE(f.centroid.y, static_cast<float>(texel.y + 1) + 3e-4f);
      area[f.triangle] += static_cast<double>(f.area);
      surface[f.triangle] += static_cast<double>(f.surface);
    }
  }
  for (std::size_t t = 0; t < scene.triangles.size(); ++t) {
    if (layout.chart_of[t] == scene::kNone) {
      EXPECT_EQ(area[t], 0.0);
      continue;
    }
    const double flat = uv_area(layout, t);
    EXPECT_GT(area[t], 0.0) << t;
    if (flat > 0) {
      EXPECT_NEAR(area[t], flat, 1e-6 * flat + 2e-9) << t;
    }
    // Slivers dropped below 1e-6 of a triangle's texels, and float sums.
    EXPECT_NEAR(surface[t], world_area(scene, t), 1e-5 * world_area(scene, t)) << t;
  }
}

}  // namespace lightbatch::atlas
