#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace lightbatch::atlas {

/// Lightmap coordinates are whole multiples of 1/2048 texel: exact as float on pages of up to
/// 8192 texels, exact under quarter turns and shifts, and edge functions fit 64 bits.
constexpr std::int32_t kUnits = 2048;

struct GridPoint {
  std::int32_t x = 0, y = 0;
  constexpr bool operator==(const GridPoint&) const = default;
};
using GridTriangle = std::array<GridPoint, 3>;

constexpr std::int64_t floor_div(std::int64_t a, std::int64_t b) {  // b > 0
  return a / b - (a % b < 0 ? 1 : 0);
}
constexpr std::int64_t ceil_div(std::int64_t a, std::int64_t b) {  // b > 0
  return a / b + (a % b > 0 ? 1 : 0);
}

/// Twice the signed area in square units; counter-clockwise is positive.
constexpr std::int64_t twice_area(const GridTriangle& t) {
  return std::int64_t{t[1].x - t[0].x} * (t[2].y - t[0].y) -
         std::int64_t{t[2].x - t[0].x} * (t[1].y - t[0].y);
}

/// Samples of one row inside the triangle: [first, end). Sample (i, row) lies at
/// ((i + 1/2) step, (row + 1/2) step) units. Half-open edges in exact arithmetic: triangles that
/// share an edge never share a sample and leave none between them.
struct SampleRow {
  std::int64_t first = 0, end = 0;
};
inline SampleRow sample_row(const GridTriangle& t, std::int32_t step, std::int64_t row) {
  const std::int64_t half = step / 2;
  const std::int64_t y = row * step + half;
  SampleRow samples{INT64_MAX, INT64_MIN};
  for (std::size_t k = 0; k < 3; ++k) {
    const GridPoint& p = t[k];
    const GridPoint& q = t[(k + 1) % 3];
    const GridPoint &a = p.y < q.y ? p : q, &b = p.y < q.y ? q : p;
    if (y < a.y || y >= b.y) continue;
    const std::int64_t rise = std::int64_t{b.y} - a.y;
    const std::int64_t x = a.x * rise + (std::int64_t{b.x} - a.x) * (y - a.y);  // times rise
    const std::int64_t at = ceil_div(x - half * rise, step * rise);
    samples.first = std::min(samples.first, at);
    samples.end = std::max(samples.end, at);
  }
  return samples.first < samples.end ? samples : SampleRow{};
}

/// Calls span(row, first, last) for all samples inside the triangle.
template <typename Span>
void sample_spans(const GridTriangle& t, std::int32_t step, Span span) {
  const std::int64_t half = step / 2;
  const std::int64_t low = std::min({t[0].y, t[1].y, t[2].y});
  const std::int64_t high = std::max({t[0].y, t[1].y, t[2].y});
  const std::int64_t end = ceil_div(high - half, step);
  for (std::int64_t row = ceil_div(low - half, step); row < end; ++row) {
    const SampleRow samples = sample_row(t, step, row);
    if (samples.first < samples.end) span(row, samples.first, samples.end - 1);
  }
}

/// Calls row(j, first, last) for the bilinear footprint: texels whose centre is less than one
/// texel, in x and in y, from a point of the triangle. Here centres lie on whole texels, so
/// subtract half a texel from page coordinates. At most one texel too wide at a corner.
template <typename Row>
void footprint_rows(const GridTriangle& t, Row row) {
  const auto [x_low, x_high] = std::minmax({t[0].x, t[1].x, t[2].x});
  const auto [y_low, y_high] = std::minmax({t[0].y, t[1].y, t[2].y});
  const std::int64_t first = floor_div(x_low, kUnits), last = ceil_div(x_high, kUnits);
  const std::int64_t bottom = floor_div(y_low, kUnits), top = ceil_div(y_high, kUnits);
  if (last - first <= 1 || top - bottom <= 1) {  // every row sees the whole triangle
    for (std::int64_t j = bottom; j <= top; ++j) row(j, first, last);
    return;
  }
  for (std::int64_t j = bottom; j <= top; ++j) {
    const std::int64_t cut[2] = {(j - 1) * kUnits, (j + 1) * kUnits};
    std::int64_t from = INT64_MAX, to = INT64_MIN;
    for (std::size_t k = 0; k < 3; ++k) {
      const GridPoint& p = t[k];
      const GridPoint& q = t[(k + 1) % 3];
      if (p.y >= cut[0] && p.y <= cut[1]) {
        from = std::min(from, std::int64_t{p.x});
        to = std::max(to, std::int64_t{p.x});
      }
      const GridPoint &a = p.y < q.y ? p : q, &b = p.y < q.y ? q : p;
      for (const std::int64_t y : cut) {
        if (y <= a.y || y >= b.y) continue;
        const std::int64_t rise = std::int64_t{b.y} - a.y;
        const std::int64_t part = (std::int64_t{b.x} - a.x) * (y - a.y);
        from = std::min(from, a.x + floor_div(part, rise));
        to = std::max(to, a.x + ceil_div(part, rise));
      }
    }
    if (from <= to) row(j, floor_div(from, kUnits), ceil_div(to, kUnits));
  }
}

}  // namespace lightbatch::atlas
