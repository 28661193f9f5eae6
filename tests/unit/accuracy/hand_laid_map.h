#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/atlas/texels.h"
#include "core/lightmap/pages.h"
#include "tests/unit/accuracy/scene_kit.h"

namespace lightbatch::accuracy {

/// Quads of a scene laid out by hand at 10 texels a metre: each triangle pair is a chart of its
/// own, with a texel to spare around it.
struct HandLaidMap {
  SceneKit kit;
  atlas::Layout layout;
  atlas::TexelMap texels;
  std::vector<lightmap::PageImage> pages;

  HandLaidMap() { layout.texels_per_metre = 10; }

  /// Side by side; the quads were made by SceneKit::quad: corner order 0, 1, 2 and 0, 2, 3, edge 01
  /// along x, 03 along y. value(chart, x, y): lux at page coordinates relative to the chart.
  template <typename Value>
  void lay_out(Value value) {
    kit.finish();
    const scene::Scene& scene = kit.scene();
    layout.uv.resize(scene.triangles.size());
    layout.chart_of.resize(scene.triangles.size());
    int x = 1, highest = 0;
    for (std::uint32_t t = 0; t < scene.triangles.size(); t += 2) {
      const auto c = scene.corners(t);
      const auto width = static_cast<float>(10 * length(c[1] - c[0]));
      const auto height = static_cast<float>(10 * length(c[2] - c[1]));
      const auto at = [&](float u, float v) {
        return Vec2f{static_cast<float>(x) + 0.5f + u, 1.5f + v};
      };
      layout.uv[t] = {at(0, 0), at(width, 0), at(width, height)};
      layout.uv[t + 1] = {at(0, 0), at(width, height), at(0, height)};
      atlas::Chart chart;
      chart.x = x;
      chart.y = 1;
      chart.width = static_cast<int>(width) + 1;
      chart.height = static_cast<int>(height) + 1;
      layout.chart_of[t] = layout.chart_of[t + 1] = t / 2;
      layout.charts.push_back(chart);
      x += chart.width + 2;
      highest = std::max(highest, chart.height + 2);
    }
    layout.pages.push_back({x, highest});
    texels = atlas::cover_texels(scene, layout);
    std::vector<Rgb> light;
    for (const atlas::Texel& texel : texels.texels) {
      const atlas::Chart& chart = layout.charts[texel.chart];
      light.push_back(Rgb::grey(value(texel.chart, texel.x - chart.x, texel.y - chart.y)));
    }
    pages = lightmap::make_pages(layout, texels, light);
  }
};

inline std::array<Vec3f, 4> floor(float x0, float x1, float depth = 2, float tilt = 0) {
  const float rise = tilt * (x1 - x0);
  return {Vec3f{x0, 0, depth}, {x1, rise, depth}, {x1, rise, 0}, {x0, 0, 0}};
}

}  // namespace lightbatch::accuracy
