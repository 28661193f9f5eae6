#include "core/atlas/box.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace lightbatch::atlas {
namespace {

/// Counter-clockwise, without collinear points; fewer than three points when all lie on a line.
std::vector<Vec2d> convex_hull(std::vector<Vec2d>& points) {
  std::sort(points.begin(), points.end(),
            [](const Vec2d& a, const Vec2d& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  std::vector<Vec2d> hull;
  const auto add = [&](const Vec2d& p, std::size_t base) {
    while (hull.size() >= base + 2 &&
           cross(hull[hull.size() - 1] - hull[hull.size() - 2], p - hull[hull.size() - 2]) <= 0) {
      hull.pop_back();
    }
    hull.push_back(p);
  };
  for (const Vec2d& p : points) add(p, 0);
  const std::size_t lower = hull.size() - 1;
  for (std::size_t i = points.size() - 1; i-- > 0;) add(points[i], lower);
  hull.pop_back();
  return hull;
}

double along(const Vec2d& a, const Vec2d& p) { return a.x * p.x + a.y * p.y; }

Box box_along(const std::vector<Vec2d>& hull, const Vec2d& axis) {
  Box box;
  box.axis = axis;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  double u_low = kFar, u_high = -kFar, v_low = kFar, v_high = -kFar;
  for (const Vec2d& p : hull) {
    u_low = std::min(u_low, along(axis, p));
    u_high = std::max(u_high, along(axis, p));
    v_low = std::min(v_low, cross(axis, p));
    v_high = std::max(v_high, cross(axis, p));
  }
  box.lower = {u_low, v_low};
  box.size = {u_high - u_low, v_high - v_low};
  return box;
}

}  // namespace

Box smallest_box(std::vector<Vec2d>& points) {
  if (points.empty()) return {};
  const std::vector<Vec2d> hull = convex_hull(points);
  const std::size_t n = hull.size();
  if (n < 3) {
    const Vec2d side = points.back() - points.front();
    const double size = std::sqrt(along(side, side));
    return box_along(points, size > 0 ? side * (1 / size) : Vec2d{1, 0});
  }
  double best_area = std::numeric_limits<double>::infinity();
  Vec2d best_axis{1, 0};
  std::size_t right = 0, top = 0, left = 0;  // extremal points, only ever moving on
  const auto follow = [&](std::size_t& at, std::size_t from, const Vec2d& way) {
    at = std::max(at, from);
    while (along(way, hull[(at + 1) % n]) > along(way, hull[at % n])) ++at;
  };
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2d side = hull[(i + 1) % n] - hull[i];
    const double size = std::sqrt(along(side, side));
    if (!(size > 0)) continue;
    const Vec2d axis = side * (1 / size), up{-axis.y, axis.x};
    follow(right, i + 1, axis);
    follow(top, right, up);
    follow(left, top, axis * -1.0);
    const double w = along(axis, hull[right % n]) - along(axis, hull[left % n]);
    const double h = along(up, hull[top % n]) - along(up, hull[i]);
    if (w * h < best_area * (1 - 1e-9)) {
      best_area = w * h;
      best_axis = axis;
    }
  }
  return box_along(hull, best_axis);
}

}  // namespace lightbatch::atlas
