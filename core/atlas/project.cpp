#include "core/atlas/project.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/atlas/box.h"
#include "core/atlas/facets.h"

namespace lightbatch::atlas {
namespace {

struct Cone {
  double least = 1;  // cosine of the worst normal
  Vec3d worst;
};

Cone cone_about(const Mesh& mesh, std::span<const std::uint32_t> triangles, const Vec3d& axis) {
  Cone cone;
  cone.worst = axis;
  for (const std::uint32_t t : triangles) {
    if (mesh.slack[t] > kNoNormal) continue;
    const double cosine = dot(axis, mesh.normals[t]);
    if (cosine < cone.least) cone = {cosine, mesh.normals[t]};
  }
  return cone;
}

/// Area-weighted mean normal; where the projection would squeeze the worst normal below 0.71, the
/// best of the hint and of steps from the mean towards the worst (Badoiu and Clarkson 2003).
Vec3d best_axis(const Mesh& mesh, std::span<const std::uint32_t> triangles, const Vec3d& hint) {
  Vec3d sum;
  for (const std::uint32_t t : triangles) {
    if (mesh.slack[t] <= kNoNormal) sum += mesh.normals[t] * mesh.areas[t];
  }
  Vec3d best = length(sum) > 0 ? normalized(sum) : hint;
  Cone cone = cone_about(mesh, triangles, best);
  constexpr double kEnough = 0.71;
  if (cone.least >= kEnough) return best;
  double best_least = cone.least;
  const auto consider = [&](const Vec3d& axis) {
    cone = cone_about(mesh, triangles, axis);
    if (cone.least <= best_least) return;
    best_least = cone.least;
    best = axis;
  };
  Vec3d axis = best;
  consider(hint);
  cone = cone_about(mesh, triangles, axis);
  constexpr int kRounds = 16;
  for (int round = 0; round < kRounds && best_least < kEnough; ++round) {
    axis = normalized(axis + (cone.worst - axis) * (1.0 / (2 + round)));
    consider(axis);
  }
  return best;
}

bool all_coplanar(const Mesh& mesh, std::span<const std::uint32_t> triangles, const Vec3d& axis) {
  return std::all_of(triangles.begin(), triangles.end(), [&](std::uint32_t t) {
    const double slack = static_cast<double>(mesh.slack[t]);
    return mesh.slack[t] > kNoNormal ||
           length(mesh.normals[t] - axis) <= 2 * kCoplanarAngle + slack;
  });
}

std::pair<Vec3d, Vec3d> tangents(const Vec3d& n) {
  const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  const Vec3d other = x <= y && x <= z ? Vec3d{1, 0, 0} : y <= z ? Vec3d{0, 1, 0} : Vec3d{0, 0, 1};
  const Vec3d u = normalized(cross(other, n));
  return {u, cross(n, u)};
}

void collect_points(const Mesh& mesh, const FlatChart& chart, ProjectScratch& scratch) {
  if (scratch.stamp.size() < mesh.points.size()) scratch.stamp.resize(mesh.points.size(), 0);
  ++scratch.stamps;
  scratch.points.clear();
  for (const std::uint32_t t : chart.triangles) {
    for (const std::uint32_t p : mesh.corners[t]) {
      if (scratch.stamp[p] == scratch.stamps) continue;
      scratch.stamp[p] = scratch.stamps;
      scratch.points.push_back(chart.map(mesh.points[p]));
    }
  }
}

}  // namespace

FlatChart project_chart(const Mesh& mesh, std::vector<std::uint32_t> triangles, const Vec3d& hint,
                        std::span<const std::uint32_t> chart_of, ProjectScratch& scratch) {
  FlatChart chart;
  chart.triangles = std::move(triangles);
  chart.axis = best_axis(mesh, chart.triangles, hint);
  chart.coplanar = all_coplanar(mesh, chart.triangles, chart.axis);
  const double squeeze =
      chart.coplanar ? 1.0 : std::max(0.1, cone_about(mesh, chart.triangles, chart.axis).least);
  const double stretch = std::clamp(0.71 / squeeze, 1.0, 1.3);
  chart.least = squeeze * stretch;
  chart.most = stretch;

  const auto [x, y] = tangents(chart.axis);
  chart.u = x;
  chart.v = y;
  // Coordinates about a point of the chart: differences of large numbers keep their digits.
  const Vec3d base = mesh.points[mesh.corners[chart.triangles[0]][0]];
  chart.u0 = dot(x, base);
  chart.v0 = dot(y, base);
  collect_points(mesh, chart, scratch);
  const Box box = smallest_box(scratch.points);
  chart.u = (x * box.axis.x + y * box.axis.y) * stretch;
  chart.v = (y * box.axis.x - x * box.axis.y) * stretch;
  chart.u0 = dot(chart.u, base) + box.lower.x * stretch;
  chart.v0 = dot(chart.v, base) + box.lower.y * stretch;
  chart.width = box.size.x * stretch;
  chart.height = box.size.y * stretch;

  for (const std::uint32_t t : chart.triangles) {
    chart.area += mesh.areas[t];
    chart.flat_area += mesh.areas[t] * std::abs(dot(chart.axis, mesh.normals[t]));
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t twin = mesh.twin[3 * t + k];
      if (twin != scene::kNone && chart_of[twin / 3] == chart_of[t]) continue;
      const auto& c = mesh.corners[t];
      const Vec3d side = mesh.points[c[(k + 1) % 3]] - mesh.points[c[k]];
      chart.outline += (std::abs(dot(chart.u, side)) + std::abs(dot(chart.v, side))) / 2;
    }
  }
  chart.flat_area *= stretch * stretch;
  return chart;
}

double footprint_estimate(const FlatChart& chart, double density, int max_side) {
  const double limit = max_side - 1;
  const double w = std::min(chart.width * density, limit);
  const double h = std::min(chart.height * density, limit);
  if (w < 0.5 && h < 0.5) return 0.8 * std::max(w, h);  // shares a texel
  const auto side = [](double size) {
    return size < 0.5 ? 1.0 : std::max(2.0, std::floor(size + 1.4));
  };
  const double rectangle = side(w) * side(h);
  const double full = chart.width * density * chart.height * density;
  const double shrink = full > 0 ? w * h / full : 0.0;  // a chart wider than a page is squeezed
  const double outline = chart.flat_area * density * density * shrink +
                         chart.outline * density * std::sqrt(shrink) + 1;
  return std::min(rectangle, outline);
}

}  // namespace lightbatch::atlas
