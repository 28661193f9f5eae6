#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/random.h"
#include "core/hierarchy/hierarchy.h"
#include "core/rays/caster.h"

namespace lightbatch::rays::testing {

struct Mesh {
  std::vector<Vec3f> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  void add(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
    const auto first = static_cast<std::uint32_t>(positions.size());
    positions.insert(positions.end(), {a, b, c});
    triangles.push_back({first, first + 1, first + 2});
  }
  std::vector<Aabb> boxes() const {
    std::vector<Aabb> result(triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      for (const std::uint32_t corner : triangles[i]) result[i].add(positions[corner]);
    }
    return result;
  }
  Caster caster(std::span<const Surface> surfaces = {}) const {
    return Caster(hierarchy::build(boxes()), positions, triangles, surfaces);
  }
};

inline Vec3f random_point(Random& random) {
  return {random.next_float(), random.next_float(), random.next_float()};
}
inline Vec3f random_direction(Random& random) {
  while (true) {
    const Vec3f d = random_point(random) * 2.0f - Vec3f{1, 1, 1};
    const float size = length(d);
    if (size > 0.1f && size < 1.0f) return d / size;
  }
}

/// Another method than the caster's: Moeller and Trumbore (1997) in double over all triangles.
/// `margin` tells how clear the answer is: the smallest barycentric distance to an edge, relative,
/// of any triangle in range.
struct OracleHit {
  std::uint32_t triangle = kNoTriangle;
  double t = 0, u = 0, v = 0;
};
struct Oracle {
  static bool test(const Mesh& mesh, std::uint32_t i, const Ray& ray, OracleHit& hit,
                   double& margin) {
    const Vec3d a = to_double(mesh.positions[mesh.triangles[i][0]]);
    const Vec3d e1 = to_double(mesh.positions[mesh.triangles[i][1]]) - a;
    const Vec3d e2 = to_double(mesh.positions[mesh.triangles[i][2]]) - a;
    const Vec3d d = to_double(ray.direction);
    const Vec3d p = cross(d, e2);
    const double det = dot(e1, p);
    if (det == 0) return false;
    const Vec3d s = to_double(ray.origin) - a;
    const double u = dot(s, p) / det;
    const Vec3d q = cross(s, e1);
    const double v = dot(d, q) / det;
    const double t = dot(e2, q) / det;
    const double least = std::min(u, std::min(v, 1 - u - v));
    margin = std::min(margin, std::abs(least));
    hit = {i, t, u, v};
    return least >= 0 && t > static_cast<double>(ray.t_min) && t < static_cast<double>(ray.t_max);
  }
  static OracleHit closest(const Mesh& mesh, const Ray& ray, std::uint32_t exclude,
                           double& margin) {
    OracleHit best;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      OracleHit hit;
      if (i == exclude || !test(mesh, i, ray, hit, margin)) continue;
      if (best.triangle == kNoTriangle || hit.t < best.t) best = hit;
    }
    return best;
  }
};

/// Triangles of about one size anywhere in the unit cube.
inline Mesh soup(std::size_t n, float size, std::uint64_t seed) {
  Random random(seed);
  Mesh mesh;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3f at = random_point(random);
    mesh.add(at, at + random_direction(random) * size, at + random_direction(random) * size);
  }
  return mesh;
}

}  // namespace lightbatch::rays::testing
