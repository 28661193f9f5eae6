#include "core/lightmap/look_up.h"

#include <algorithm>
#include <cmath>

namespace lightbatch::lightmap {

Taps taps_at(const PageImage& page, Vec2f at) {
  const float x = at.x - 0.5f;
  const float y = at.y - 0.5f;
  const float fx = std::floor(x);
  const float fy = std::floor(y);
  const float s = x - fx;
  const float t = y - fy;
  const int width = page.irradiance.width;
  const auto pixel = [&](int i, int j) {
    const int column = std::clamp(i, 0, width - 1);
    const int row = std::clamp(j, 0, page.irradiance.height - 1);
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(column);
  };
  const int i = static_cast<int>(fx);
  const int j = static_cast<int>(fy);
  return {{pixel(i, j), pixel(i + 1, j), pixel(i, j + 1), pixel(i + 1, j + 1)},
          {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t}};
}

Rgb look_up(const PageImage& page, Vec2f at) { return look_up(page, taps_at(page, at)); }

Rgb look_up(const PageImage& page, const Taps& taps) {
  Rgb sum{};
  for (std::size_t k = 0; k < 4; ++k) {
    sum += page.irradiance.pixels[taps.pixel[k]] * taps.weight[k];
  }
  return sum;
}

Vec2f page_place(const atlas::Layout& layout, std::uint32_t triangle, float u, float v) {
  const auto& uv = layout.uv[triangle];
  return uv[0] * (1 - u - v) + uv[1] * u + uv[2] * v;
}

Rgb irradiance_at(const atlas::Layout& layout, const std::vector<PageImage>& pages,
                  std::uint32_t triangle, float u, float v) {
  const std::uint32_t chart = layout.chart_of[triangle];
  if (chart == scene::kNone) return {};
  return look_up(pages[layout.charts[chart].page], page_place(layout, triangle, u, v));
}

}  // namespace lightbatch::lightmap
