// Area-to-area form factor of polygons.
//
// Near pairs: the double contour integral F A_a = 1/(2 pi) sum over edge pairs of
// (t_a . t_b) int int ln r ds dt (Sparrow 1963), the inner integral in closed form, the outer by
// adaptive Gauss-Kronrod quadrature, cut first where the integrand may turn sharply. Each polygon
// is clipped to the front of the other's plane, which the contour form needs.
// Distant pairs, where the contour sum would cancel: the exact point-to-polygon factor integrated
// by Radon's seven points of degree 5 (Stroud 1971, T2 5-1).
#include "core/radiosity/form_factor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <vector>

#include "core/math/sampling.h"
#include "core/radiosity/polygon_form_factor.h"

namespace lightbatch::radiosity {
namespace {

constexpr std::size_t kMaxIntervals = 20000;
/// Distance over size from which seven points on each of 64 parts are exact to 1e-9.
constexpr double kDistant = 10;

using Polygon = std::vector<Vec3d>;

/// The part of a convex polygon on the positive side of the plane through `origin`; empty when
/// nothing lies strictly above.
Polygon clip_to_front(std::span<const Vec3d> polygon, const Vec3d& origin, const Vec3d& normal) {
  Polygon out;
  bool above = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3d& p = polygon[i];
    const Vec3d& q = polygon[(i + 1) % polygon.size()];
    const double zp = dot(normal, p - origin);
    const double zq = dot(normal, q - origin);
    above |= zp > 0;
    if (zp >= 0) out.push_back(p);
    if ((zp > 0 && zq < 0) || (zp < 0 && zq > 0)) out.push_back(p + (q - p) * (zp / (zp - zq)));
  }
  return above ? out : Polygon{};
}

struct Edge {
  Vec3d start, direction;  // unit
  double size = 0;
};

std::vector<Edge> edges_of(const Polygon& polygon) {
  std::vector<Edge> edges;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3d along = polygon[(i + 1) % polygon.size()] - polygon[i];
    const double size = length(along);
    if (size > 0) edges.push_back({polygon[i], along / size, size});
  }
  return edges;
}

/// int ln r over the edge, seen from x.
double log_distance(const Vec3d& x, const Edge& edge) {
  const Vec3d to_start = edge.start - x;
  const double s0 = dot(to_start, edge.direction), s1 = s0 + edge.size;
  const Vec3d across = cross(edge.direction, to_start);
  const double h2 = dot(across, across), h = std::sqrt(h2);
  const auto part = [h2](double s) {
    const double r2 = s * s + h2;
    return r2 > 0 ? 0.5 * s * std::log(r2) : 0;
  };
  return part(s1) - part(s0) - edge.size + h * std::atan2(h * edge.size, h2 + s0 * s1);
}

struct Interval {
  std::uint32_t a = 0, b = 0;  // edges
  double from = 0, to = 0, value = 0, error = 0;
  bool operator<(const Interval& other) const { return error < other.error; }
};

/// Gauss-Kronrod 7-15.
void estimate(const std::vector<Edge>& a, const std::vector<Edge>& b, Interval& interval) {
  constexpr std::array<double, 8> kNode = {
      0.991455371120812639, 0.949107912342758525, 0.864864423359769073, 0.741531185599394440,
      0.586087235467691130, 0.405845151377397167, 0.207784955007898468, 0};
  constexpr std::array<double, 8> kKronrod = {
      0.022935322010529225, 0.063092092629978553, 0.104790010322250184, 0.140653259715525919,
      0.169004726639267903, 0.190350578064785410, 0.204432940075298892, 0.209482141084727828};
  constexpr std::array<double, 4> kGauss = {0.129484966168869693, 0.279705391489276668,
                                            0.381830050505118945, 0.417959183673469388};
  const Edge& edge = a[interval.a];
  const Edge& other = b[interval.b];
  const double middle = (interval.from + interval.to) / 2, half = (interval.to - interval.from) / 2;
  const auto at = [&](double u) {
    return log_distance(edge.start + edge.direction * (middle + half * u), other);
  };
  double fine = kKronrod[7] * at(0), coarse = kGauss[3] * at(0);
  for (std::size_t i = 0; i < 7; ++i) {
    const double pair = at(kNode[i]) + at(-kNode[i]);
    fine += kKronrod[i] * pair;
    if (i % 2 == 1) coarse += kGauss[i / 2] * pair;
  }
  const double weight = half * dot(edge.direction, other.direction);
  interval.value = fine * weight;
  interval.error = std::abs((fine - coarse) * weight);
}

/// Places on edge a nearest to the ends of b and to its line: where ln r may turn sharply.
std::vector<double> breaks(const Edge& a, const Edge& b) {
  const Vec3d apart = b.start - a.start;
  const double along = dot(a.direction, b.direction);
  std::vector<double> cuts = {0, a.size};
  const auto add = [&](double u) {
    if (u > 0 && u < a.size) cuts.push_back(u);
  };
  add(dot(apart, a.direction));
  add(dot(apart, a.direction) + b.size * along);
  const double sine2 = 1 - along * along;
  if (sine2 > 1e-12) add(dot(apart, a.direction - b.direction * along) / sine2);
  std::sort(cuts.begin(), cuts.end());
  return cuts;
}

/// 2 pi F A of two clipped polygons.
double contour_integral(const Polygon& from, const Polygon& to, double relative_tolerance) {
  const std::vector<Edge> a = edges_of(from), b = edges_of(to);
  std::priority_queue<Interval> intervals;
  double sum = 0, error = 0;
  const auto push = [&](Interval interval) {
    estimate(a, b, interval);
    sum += interval.value;
    error += interval.error;
    intervals.push(interval);
  };
  for (std::uint32_t i = 0; i < a.size(); ++i) {
    for (std::uint32_t j = 0; j < b.size(); ++j) {
      const std::vector<double> cuts = breaks(a[i], b[j]);
      for (std::size_t k = 1; k < cuts.size(); ++k) {
        if (cuts[k] > cuts[k - 1]) push({i, j, cuts[k - 1], cuts[k], 0, 0});
      }
    }
  }
  while (!intervals.empty() && intervals.size() < kMaxIntervals &&
         error > relative_tolerance * std::abs(sum)) {
    const Interval worst = intervals.top();
    const double middle = (worst.from + worst.to) / 2;
    if (!(worst.error > 0) || !(middle > worst.from && middle < worst.to)) break;
    intervals.pop();
    sum -= worst.value;
    error -= worst.error;
    push({worst.a, worst.b, worst.from, middle, 0, 0});
    push({worst.a, worst.b, middle, worst.to, 0, 0});
  }
  // Summed afresh: the running sum has gathered rounding.
  sum = 0;
  for (; !intervals.empty(); intervals.pop()) sum += intervals.top().value;
  return sum;
}

/// Integral over a triangle of the factor to `seen`, the triangle cut in four `rounds` times.
double cubature(const std::array<Vec3d, 3>& t, const Vec3d& normal, const Polygon& seen,
                int rounds) {
  if (rounds > 0) {
    const Vec3d ab = (t[0] + t[1]) * 0.5, bc = (t[1] + t[2]) * 0.5, ca = (t[2] + t[0]) * 0.5;
    return cubature({t[0], ab, ca}, normal, seen, rounds - 1) +
           cubature({ab, t[1], bc}, normal, seen, rounds - 1) +
           cubature({ca, bc, t[2]}, normal, seen, rounds - 1) +
           cubature({ab, bc, ca}, normal, seen, rounds - 1);
  }
  const double r = std::sqrt(15.0);
  const double near = (6 - r) / 21, far = (6 + r) / 21;
  const auto at = [&](double u, double v) {
    return point_to_polygon(t[0] * (1 - u - v) + t[1] * u + t[2] * v, normal, seen);
  };
  const double inner = at(near, near) + at(1 - 2 * near, near) + at(near, 1 - 2 * near);
  const double outer = at(far, far) + at(1 - 2 * far, far) + at(far, 1 - 2 * far);
  return length(cross(t[1] - t[0], t[2] - t[0])) / 2 *
         (9.0 / 40 * at(1.0 / 3, 1.0 / 3) + (155 - r) / 1200 * inner + (155 + r) / 1200 * outer);
}

struct Ball {
  Vec3d centre;
  double radius = 0;
};
Ball ball_of(const Polygon& polygon) {
  Ball ball;
  for (const Vec3d& p : polygon) ball.centre += p / static_cast<double>(polygon.size());
  for (const Vec3d& p : polygon) ball.radius = std::max(ball.radius, length(p - ball.centre));
  return ball;
}

}  // namespace

Vec3d doubled_area(std::span<const Vec3d> polygon) {
  Vec3d sum;
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    sum += cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
  }
  return sum;
}

double form_factor(std::span<const Vec3d> a, std::span<const Vec3d> b, double relative_tolerance) {
  if (a.size() < 3 || b.size() < 3) return 0;
  const Vec3d normal_a = doubled_area(a), normal_b = doubled_area(b);
  const double area_a = length(normal_a) / 2;
  if (!(area_a > 0) || !(length(normal_b) > 0)) return 0;
  Polygon from = clip_to_front(a, b[0], normal_b);
  Polygon to = clip_to_front(b, a[0], normal_a);
  if (from.size() < 3 || to.size() < 3) return 0;

  const Ball ball_a = ball_of(from), ball_b = ball_of(to);
  const double apart = length(ball_b.centre - ball_a.centre);
  double power = 0;
  if (apart > kDistant * (ball_a.radius + ball_b.radius)) {
    const Vec3d unit = normalized(normal_a);
    for (std::size_t i = 2; i < from.size(); ++i) {
      power += cubature({from[0], from[i - 1], from[i]}, unit, to, 3);
    }
  } else {
    // The unit of length is free (a constant added to ln r integrates to 0): r about 1 loses least.
    const double unit = std::max(apart, ball_a.radius + ball_b.radius);
    for (Vec3d& p : from) p = (p - ball_a.centre) / unit;
    for (Vec3d& p : to) p = (p - ball_a.centre) / unit;
    power = contour_integral(from, to, relative_tolerance) * unit * unit / (2 * kPiDouble);
  }
  return std::clamp(power / area_a, 0.0, 1.0);
}

}  // namespace lightbatch::radiosity
