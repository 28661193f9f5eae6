#include "core/atlas/raster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "core/base/parallel.h"

namespace lightbatch::atlas {
namespace {

/// Whole texels for a side of `size` texels, or `size` itself where rounding would leave the
/// bound of +-30 % (then the footprint is as large as rounded up). Rounds down up to 0.6: a
/// texel more on a short side costs more than it resolves.
double snapped(double size, const FlatChart& chart, double squeeze) {
  constexpr double kRoundUp = 0.6;
  if (size < 0.5) return 0;
  if (size < 2) return size < 1 + kRoundUp ? 1 : 2;
  const auto fits = [&](double whole) {
    const double factor = whole / size;
    return chart.least * squeeze * factor >= 0.7 && chart.most * squeeze * factor <= 1.3;
  };
  const double nearest = std::floor(size + 1 - kRoundUp);
  if (fits(nearest)) return nearest;
  const double other = nearest > size ? nearest - 1 : nearest + 1;
  return fits(other) ? other : size;
}

/// Texel cell and dominant half axis of a chart that is smaller than a texel.
using CellKey = std::array<std::int64_t, 4>;
CellKey cell_of(const Mesh& mesh, const FlatChart& chart, double density) {
  Vec3d centre;
  double area = 0;
  for (const std::uint32_t t : chart.triangles) {
    const auto& c = mesh.corners[t];
    centre += (mesh.points[c[0]] + mesh.points[c[1]] + mesh.points[c[2]]) * (mesh.areas[t] / 3);
    area += mesh.areas[t];
  }
  centre = centre / area * density;
  const Vec3d& n = chart.axis;
  const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  const std::size_t axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
  const auto cell = [](double c) {  // far cells of absurd scenes may fall together
    return static_cast<std::int64_t>(std::floor(std::clamp(c, -1e15, 1e15)));
  };
  return {cell(centre.x), cell(centre.y), cell(centre.z),
          static_cast<std::int64_t>(2 * axis + (n[axis] < 0 ? 1 : 0))};
}

void raster_one(const Mesh& mesh, const FlatChart& chart, double density, int max_side,
                BlockChart& out, std::vector<GridTriangle>& uv) {
  const Vec2d scale = chart_scale(chart, density, max_side);
  const double w = chart.width * scale.x, h = chart.height * scale.y;
  const double limit = max_side - 1;
  const double sw = std::min(limit, snapped(w, chart, scale.x / density));
  const double sh = std::min(limit, snapped(h, chart, scale.y / density));
  const double fx = w > 0 ? scale.x * (sw / w) * kUnits : 0;
  const double fy = h > 0 ? scale.y * (sh / h) * kUnits : 0;
  out.axis = to_float(chart.axis);
  out.first_triangle = chart.triangles[0];
  out.triangle_count = static_cast<std::uint32_t>(chart.triangles.size());
  out.tiny = sw == 0 && sh == 0;
  out.wide = w >= 2 && h >= 2;
  out.mask = Mask(static_cast<int>(std::ceil(sw)) + 1, static_cast<int>(std::ceil(sh)) + 1);
  const double x_end = std::ceil(sw) * kUnits, y_end = std::ceil(sh) * kUnits;
  for (const std::uint32_t t : chart.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2d p = chart.map(mesh.points[mesh.corners[t][k]]);
      uv[t][k] = {static_cast<std::int32_t>(std::lround(std::clamp(p.x * fx, 0.0, x_end))),
                  static_cast<std::int32_t>(std::lround(std::clamp(p.y * fy, 0.0, y_end)))};
    }
    footprint_rows(uv[t], [&](std::int64_t row, std::int64_t first, std::int64_t last) {
      out.mask.set_span(static_cast<int>(row), static_cast<int>(first), static_cast<int>(last));
    });
  }
}

/// Folds tiny charts of one cell and direction into the first of them.
void share_tiny(const Mesh& mesh, const ChartSet& set, double density, Block& block) {
  std::vector<std::pair<CellKey, std::uint32_t>> tiny;
  for (std::uint32_t c = 0; c < block.charts.size(); ++c) {
    if (block.charts[c].tiny) tiny.emplace_back(cell_of(mesh, set.charts[c], density), c);
  }
  if (tiny.empty()) return;
  std::sort(tiny.begin(), tiny.end());
  std::vector<std::uint32_t> into(block.charts.size());
  for (std::uint32_t c = 0; c < into.size(); ++c) into[c] = c;
  for (std::size_t i = 1; i < tiny.size(); ++i) {
    if (tiny[i].first == tiny[i - 1].first) into[tiny[i].second] = into[tiny[i - 1].second];
  }
  std::vector<std::uint32_t> place(block.charts.size());
  std::vector<BlockChart> kept;
  for (std::uint32_t c = 0; c < into.size(); ++c) {
    if (into[c] == c) {
      place[c] = static_cast<std::uint32_t>(kept.size());
      kept.push_back(std::move(block.charts[c]));
    } else {
      kept[place[into[c]]].triangle_count += block.charts[c].triangle_count;
    }
  }
  for (std::uint32_t& c : block.chart_of) c = place[into[c]];
  block.charts = std::move(kept);
}

}  // namespace

Block raster_charts(const Mesh& mesh, const ChartSet& set, double density, int max_side) {
  Block block;
  block.chart_of = set.of;
  block.charts.resize(set.charts.size());
  block.uv.resize(mesh.size());
  parallel_for(set.charts.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      raster_one(mesh, set.charts[c], density, max_side, block.charts[c], block.uv);
    }
  });
  share_tiny(mesh, set, density, block);
  return block;
}

}  // namespace lightbatch::atlas
