#include "core/atlas/fragments.h"

#include <cmath>
#include <tuple>

#include "core/atlas/clip.h"

namespace lightbatch::atlas {
namespace {

constexpr double kTexel = 1.0 / kUnits;
constexpr std::int32_t kSampleStep = kUnits / 4;

/// Parts of the line in each texel it passes.
void append_collapsed(const GridTriangle& g, std::uint32_t triangle, double surface,
                      std::int32_t first_row, std::int32_t end_row,
                      std::vector<PlacedFragment>& out) {
  const CollapsedTriangle line(g);
  const GridPoint &a = g[line.order[0]], &b = g[line.order[2]];
  std::vector<double> cuts{0.0, 1.0};
  const auto add_cuts = [&](std::int32_t from, std::int32_t to) {
    const std::int64_t low = std::min(from, to), high = std::max(from, to);
    for (std::int64_t c = floor_div(low, kUnits) + 1; c * kUnits < high; ++c) {
      cuts.push_back(static_cast<double>(c * kUnits - from) / (std::int64_t{to} - from));
    }
  };
  add_cuts(a.x, b.x);
  add_cuts(a.y, b.y);
  std::sort(cuts.begin(), cuts.end());
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const double share =
        line.point ? 1.0 : line.share_before(cuts[i + 1]) - line.share_before(cuts[i]);
    const double middle = (cuts[i] + cuts[i + 1]) / 2;
    const double x = (a.x + (b.x - a.x) * middle) * kTexel;
    const double y = (a.y + (b.y - a.y) * middle) * kTexel;
    PlacedFragment f;
    f.x = static_cast<std::int32_t>(std::floor(x));
    f.y = static_cast<std::int32_t>(std::floor(y));
    if (!(share > 0) || f.y < first_row || f.y >= end_row) continue;
    f.fragment = {triangle,
                  0,
                  kCollapsedArea,
                  {static_cast<float>(x), static_cast<float>(y)},
                  static_cast<float>(surface * share)};
    out.push_back(f);
  }
}

/// Samples of one texel, from those of its four sample rows.
unsigned sample_mask(const SampleRow (&rows)[4], std::int32_t x) {
  unsigned mask = 0;
  for (unsigned s = 0; s < 4; ++s) {
    const std::int64_t from = std::clamp<std::int64_t>(rows[s].first - 4 * std::int64_t{x}, 0, 4);
    const std::int64_t to = std::clamp<std::int64_t>(rows[s].end - 4 * std::int64_t{x}, 0, 4);
    if (from < to) mask |= ((1u << to) - (1u << from)) << (4 * s);
  }
  return mask;
}

/// One texel row of a triangle: coordinates relative to (x0, row).
class RowClipper {
 public:
  RowClipper(const GridTriangle& g, std::int32_t row, std::int32_t x0) {
    Polygon triangle;
    for (const GridPoint& p : g) {
      triangle.add({(p.x - x0 * kUnits) * kTexel, (p.y - row * kUnits) * kTexel});
    }
    strip_ = clipped(clipped(triangle, true, 0.0, 1.0), true, 1.0, -1.0);
    // Columns are full between the sides' innermost points at the strip's lower and upper edge.
    double left[2] = {1e300, 1e300}, right[2] = {-1e300, -1e300};
    for (std::size_t i = 0; i < strip_.count; ++i) {
      const Vec2d& p = strip_.corners[i];
      low = std::min(low, p.x);
      high = std::max(high, p.x);
      for (std::size_t edge = 0; edge < 2; ++edge) {
        if (p.y != static_cast<double>(edge)) continue;
        left[edge] = std::min(left[edge], p.x);
        right[edge] = std::max(right[edge], p.x);
      }
    }
    full_from_ = std::max(left[0], left[1]);
    full_to_ = std::min(right[0], right[1]);
  }

  /// Whether the triangle holds the whole texel.
  bool is_full(std::int32_t column) const { return column >= full_from_ && column + 1 <= full_to_; }
  AreaCentroid cell(std::int32_t column) const {
    return area_centroid(clipped(clipped(strip_, false, column, 1.0), false, column + 1.0, -1.0));
  }

  double low = 1e300, high = -1e300;

 private:
  Polygon strip_;
  double full_from_ = 0, full_to_ = 0;
};

}  // namespace

CollapsedTriangle::CollapsedTriangle(const GridTriangle& g) : order{0, 1, 2} {
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tie(g[a].x, g[a].y) < std::tie(g[b].x, g[b].y);
  });
  const GridPoint &a = g[order[0]], &m = g[order[1]], &b = g[order[2]];
  point = a == b;
  if (a.x != b.x) {
    middle = static_cast<double>(m.x - a.x) / (b.x - a.x);
  } else if (a.y != b.y) {
    middle = static_cast<double>(m.y - a.y) / (b.y - a.y);
  }
}

double CollapsedTriangle::share_before(double t) const {
  if (t <= 0) return 0;
  if (t >= 1) return 1;
  return t < middle ? t * t / middle : 1 - (1 - t) * (1 - t) / (1 - middle);
}

RowRange texel_rows(const GridTriangle& g) {
  const auto [low, high] = std::minmax({g[0].y, g[1].y, g[2].y});
  const auto first = static_cast<std::int32_t>(floor_div(low, kUnits));
  const auto last = static_cast<std::int32_t>(ceil_div(high, kUnits)) - 1;
  return {first, std::max(first, last)};
}

void append_fragments(const GridTriangle& g, std::uint32_t triangle, double surface,
                      std::int32_t first_row, std::int32_t end_row,
                      std::vector<PlacedFragment>& out) {
  const std::int64_t twice = twice_area(g);
  if (twice == 0) {
    append_collapsed(g, triangle, surface, first_row, end_row, out);
    return;
  }
  const double uv_area = std::abs(static_cast<double>(twice)) / (2.0 * kUnits * kUnits);
  const double negligible = std::min(1e-9, 1e-6 * uv_area);
  const auto [x_low, x_high] = std::minmax({g[0].x, g[1].x, g[2].x});
  const auto x0 = static_cast<std::int32_t>(floor_div(x_low, kUnits));
  const RowRange rows = texel_rows(g);
  const auto append = [&](std::int32_t x, std::int32_t y, unsigned mask, const AreaCentroid& part) {
    PlacedFragment f;
    f.x = x;
    f.y = y;
    f.fragment = {
        triangle,
        static_cast<std::uint16_t>(mask),
        static_cast<float>(std::max(part.area, 1e-12)),
        {static_cast<float>(x0 + part.centroid.x), static_cast<float>(y + part.centroid.y)},
        static_cast<float>(surface * part.area / uv_area)};
    out.push_back(f);
  };
  for (std::int32_t y = std::max(rows.first, first_row); y <= std::min(rows.last, end_row - 1);
       ++y) {
    SampleRow samples[4];
    for (std::int32_t s = 0; s < 4; ++s) samples[s] = sample_row(g, kSampleStep, 4 * y + s);
    if (rows.first == rows.last && x_high <= (x0 + 1) * kUnits) {  // all within one texel
      Vec2d sum;
      for (const GridPoint& p : g) {
        sum = sum + Vec2d{(p.x - x0 * kUnits) * kTexel, (p.y - y * kUnits) * kTexel};
      }
      const AreaCentroid part{uv_area, sum * (1.0 / 3)};
      append(x0, y, sample_mask(samples, x0), part);
      return;
    }
    const RowClipper strip(g, y, x0);
    const auto last = static_cast<std::int32_t>(std::ceil(strip.high));
    for (auto column = static_cast<std::int32_t>(std::floor(strip.low)); column < last; ++column) {
      if (strip.is_full(column)) {
        append(x0 + column, y, 0xffff, {1.0, {column + 0.5, 0.5}});
        continue;
      }
      const AreaCentroid part = strip.cell(column);
      const unsigned mask = sample_mask(samples, x0 + column);
      if (part.area > negligible || mask != 0) append(x0 + column, y, mask, part);
    }
  }
}

}  // namespace lightbatch::atlas
