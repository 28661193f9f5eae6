#include "core/lightmap/look_up.h"

#include <algorithm>
#include <cmath>

namespace lightbatch::lightmap {

Rgb look_up(const PageImage& page, Vec2f at) {
  const float x = at.x - 0.5f;
  const float y = at.y - 0.5f;
  const float fx = std::floor(x);
  const float fy = std::floor(y);
  const float s = x - fx;
  const float t = y - fy;
  const auto pixel = [&](int i, int j) {
    return page.irradiance.at(std::clamp(i, 0, page.irradiance.width - 1),
                              std::clamp(j, 0, page.irradiance.height - 1));
  };
  const int i = static_cast<int>(fx);
  const int j = static_cast<int>(fy);
  return (pixel(i, j) * (1 - s) + pixel(i + 1, j) * s) * (1 - t) +
         (pixel(i, j + 1) * (1 - s) + pixel(i + 1, j + 1) * s) * t;
}

Rgb irradiance_at(const atlas::Layout& layout, const std::vector<PageImage>& pages,
                  std::uint32_t triangle, float u, float v) {
  const std::uint32_t chart = layout.chart_of[triangle];
  if (chart == scene::kNone) return {};
  const auto& uv = layout.uv[triangle];
  return look_up(pages[layout.charts[chart].page], uv[0] * (1 - u - v) + uv[1] * u + uv[2] * v);
}

}  // namespace lightbatch::lightmap
