#include "core/atlas/verify.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"

namespace lightbatch::atlas {
namespace {

using scene::kNone;

/// Singular values of the map from the triangle's plane to texels.
std::array<double, 2> singular_values(const std::array<Vec3f, 3>& corners,
                                      const std::array<Vec2f, 3>& uv) {
  const Vec3d a = to_double(corners[0]);
  const Vec3d e = to_double(corners[1]) - a, f = to_double(corners[2]) - a;
  const double base = length(e);
  const double along = dot(e, f) / base, up = length(cross(e, f)) / base;
  const auto wide = [](const Vec2f& p) {
    return Vec2d{static_cast<double>(p.x), static_cast<double>(p.y)};
  };
  const Vec2d p = wide(uv[1]) - wide(uv[0]), q = wide(uv[2]) - wide(uv[0]);
  const Vec2d x = p * (1 / base);
  const Vec2d y = (q - x * along) * (1 / up);
  const double sum = x.x * x.x + x.y * x.y + y.x * y.x + y.y * y.y;
  const double product = std::abs(cross(x, y));
  const double root = std::sqrt(std::max(0.0, sum * sum - 4 * product * product));
  return {std::sqrt(std::max(0.0, (sum - root) / 2)), std::sqrt((sum + root) / 2)};
}

struct Sums {
  double area = 0, uv_area = 0, wide_area = 0, out_area = 0;
};

}  // namespace

GridTriangle grid_triangle(const Layout& layout, std::uint32_t triangle) {
  GridTriangle g;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec2f& p = layout.uv[triangle][k];
    g[k] = {static_cast<std::int32_t>(std::lround(static_cast<double>(p.x) * kUnits)),
            static_cast<std::int32_t>(std::lround(static_cast<double>(p.y) * kUnits))};
  }
  return g;
}

std::uint64_t count_conflicts(const Layout& layout) {
  std::vector<std::vector<std::uint32_t>> of_page(layout.pages.size());
  for (std::uint32_t t = 0; t < layout.chart_of.size(); ++t) {
    if (layout.chart_of[t] != kNone) of_page[layout.charts[layout.chart_of[t]].page].push_back(t);
  }
  std::vector<std::uint64_t> conflicts(layout.pages.size(), 0);
  parallel_for(layout.pages.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const Page& page = layout.pages[p];
      const std::size_t width = static_cast<std::size_t>(page.width);
      constexpr std::uint32_t kShared = kNone - 1;
      std::vector<std::uint32_t> owner(width * static_cast<std::size_t>(page.height), kNone);
      for (const std::uint32_t t : of_page[p]) {
        GridTriangle g = grid_triangle(layout, t);
        for (GridPoint& q : g) q = {q.x - kUnits / 2, q.y - kUnits / 2};
        const std::uint32_t chart = layout.chart_of[t];
        footprint_rows(g, [&](std::int64_t row, std::int64_t first, std::int64_t last) {
          if (row < 0 || row >= page.height || first < 0 || last >= page.width) {
            ++conflicts[p];
            return;
          }
          std::uint32_t* texels = owner.data() + width * static_cast<std::size_t>(row);
          for (std::int64_t i = first; i <= last; ++i) {
            std::uint32_t& texel = texels[i];
            if (texel == kNone) texel = chart;
            if (texel != chart && texel != kShared) {
              texel = kShared;
              ++conflicts[p];
            }
          }
        });
      }
    }
  });
  std::uint64_t sum = 0;
  for (const std::uint64_t c : conflicts) sum += c;
  return sum;
}

void measure(const scene::Scene& scene, const std::vector<bool>& wide, Layout& layout) {
  const double density = layout.texels_per_metre;
  const Sums sums = deterministic_reduce(
      scene.triangles.size(), 8192, Sums{},
      [&](std::size_t begin, std::size_t end) {
        Sums s;
        for (std::size_t i = begin; i < end; ++i) {
          const std::uint32_t t = static_cast<std::uint32_t>(i);
          if (layout.chart_of[t] == kNone) continue;
          const double area = scene.area(t);
          s.area += area;
          s.uv_area += std::abs(static_cast<double>(twice_area(grid_triangle(layout, t)))) /
                       (2.0 * kUnits * kUnits);
          if (!wide[layout.chart_of[t]]) continue;
          s.wide_area += area;
          const auto [least, most] = singular_values(scene.corners(t), layout.uv[t]);
          if (!(least >= 0.7 * density && most <= 1.3 * density)) s.out_area += area;
        }
        return s;
      },
      [](Sums a, const Sums& b) {
        return Sums{a.area + b.area, a.uv_area + b.uv_area, a.wide_area + b.wide_area,
                    a.out_area + b.out_area};
      });
  double texels = 0;
  for (const Page& p : layout.pages) texels += static_cast<double>(p.width) * p.height;
  layout.charted_area = sums.area;
  layout.utilisation = texels > 0 ? sums.uv_area / texels : 0;
  layout.out_of_density_area = sums.wide_area > 0 ? sums.out_area / sums.wide_area : 0;
}

}  // namespace lightbatch::atlas
