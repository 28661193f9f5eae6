#include "core/atlas/texel_part.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lightbatch::atlas {

void TexelPart::Corners::keep(double at_0, double at_1, double at_2) {
  if (at_0 >= 0 && at_1 >= 0 && at_2 >= 0) return;
  const auto value = [&](const Vec2d& p) {
    return at_0 * (1 - p.x - p.y) + at_1 * p.x + at_2 * p.y;
  };
  Corners kept;
  const auto add = [&](const Vec2d& p) {
    if (kept.count < kMostCorners) kept.corner[kept.count++] = p;
  };
  for (std::size_t i = 0; i < count; ++i) {
    const Vec2d &a = corner[i], &b = corner[(i + 1) % count];
    const double va = value(a), vb = value(b);
    if (va >= 0) add(a);
    if ((va > 0 && vb < 0) || (va < 0 && vb > 0)) add(a + (b - a) * (va / (va - vb)));
  }
  *this = kept;
}

double TexelPart::Corners::twice_area() const {
  double sum = 0;
  for (std::size_t i = 2; i < count; ++i) {
    sum += std::abs(cross(corner[i - 1] - corner[0], corner[i] - corner[0]));
  }
  return sum;
}

TexelPart::TexelPart(const GridTriangle& g, std::int32_t x, std::int32_t y) {
  Corners whole;
  for (const Vec2d& p : {Vec2d{0, 0}, Vec2d{1, 0}, Vec2d{0, 1}}) whole.corner[whole.count++] = p;
  Corners part = whole;
  for (const double side : {1.0, -1.0}) {
    const double x_side = kUnits * (x + (side < 0 ? 1.0 : 0.0));
    const double y_side = kUnits * (y + (side < 0 ? 1.0 : 0.0));
    part.keep(side * (g[0].x - x_side), side * (g[1].x - x_side), side * (g[2].x - x_side));
    part.keep(side * (g[0].y - y_side), side * (g[1].y - y_side), side * (g[2].y - y_side));
  }
  sweep(part.twice_area() > 0 ? part : whole);
}

void TexelPart::sweep(const Corners& corners) {
  double longest = 0;
  for (std::size_t i = 0; i < corners.count; ++i) {
    const Vec2d edge = corners.corner[(i + 1) % corners.count] - corners.corner[i];
    const double size = std::hypot(edge.x, edge.y);
    if (size > longest) {
      longest = size;
      axis_ = edge * (1 / size);
    }
  }
  const auto along = [&](const Vec2d& p) { return p.x * axis_.x + p.y * axis_.y; };
  const auto across = [&](const Vec2d& p) { return cross(axis_, p); };
  count_ = corners.count;
  for (std::size_t i = 0; i < count_; ++i) chord_[i].at = along(corners.corner[i]);
  std::sort(chord_.begin(), chord_.begin() + static_cast<std::ptrdiff_t>(count_),
            [](const Chord& a, const Chord& b) { return a.at < b.at; });
  for (std::size_t k = 0; k < count_; ++k) {
    Chord& c = chord_[k];
    c.from = std::numeric_limits<double>::infinity();
    c.to = -c.from;
    for (std::size_t i = 0; i < corners.count; ++i) {
      const Vec2d &a = corners.corner[i], &b = corners.corner[(i + 1) % corners.count];
      const double at_a = along(a), at_b = along(b);
      if (c.at < std::min(at_a, at_b) || c.at > std::max(at_a, at_b)) continue;
      const double t = at_b != at_a ? (c.at - at_a) / (at_b - at_a) : 0;
      for (const double v :
           {across(a + (b - a) * t), at_b != at_a ? across(a + (b - a) * t) : across(b)}) {
        c.from = std::min(c.from, v);
        c.to = std::max(c.to, v);
      }
    }
    if (k == 0) continue;
    const Chord& before = chord_[k - 1];
    c.area = before.area + (c.at - before.at) * (before.width() + c.width()) / 2;
  }
}

Vec2f TexelPart::at(Vec2f square) const {
  const double wanted = static_cast<double>(square.x) * chord_[count_ - 1].area;
  std::size_t k = 1;
  while (k + 1 < count_ && chord_[k].area < wanted) ++k;
  const Chord &a = chord_[k - 1], &b = chord_[k];
  // Width grows linearly from one chord to the next.
  const double grows = b.width() - a.width();
  const double share = b.at > a.at ? (wanted - a.area) / (b.at - a.at) : 0;
  const double root =
      a.width() + std::sqrt(std::max(0.0, a.width() * a.width() + 2 * grows * share));
  const double t = root > 0 ? std::clamp(2 * share / root, 0.0, 1.0) : 0;
  const double along = a.at + (b.at - a.at) * t;
  const double y = static_cast<double>(square.y);
  const double across = (a.from + (b.from - a.from) * t) * (1 - y) + (a.to + (b.to - a.to) * t) * y;
  const Vec2d p{axis_.x * along - axis_.y * across, axis_.y * along + axis_.x * across};
  return {static_cast<float>(p.x), static_cast<float>(p.y)};
}

}  // namespace lightbatch::atlas
