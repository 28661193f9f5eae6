#pragma once

#include <cstdint>
#include <vector>

#include "core/math/vec.h"

namespace lightbatch::generate {

/// Triangles of one material, counter-clockwise seen from outside.
struct Surface {
  std::vector<Vec3f> positions;
  std::vector<Vec3f> normals;
  std::vector<std::uint32_t> indices;

  std::uint64_t triangles() const { return indices.size() / 3; }
};

/// Corners counter-clockwise seen from the front; flat normal.
void add_quad(Surface& surface, const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);

/// Closed box; 12 triangles.
void add_box(Surface& surface, const Vec3d& lower, const Vec3d& upper);

/// Closed box with rounded edges: `steps` facets across each quarter turn (0: a plain box), radius
/// at most half the smallest edge. 12 (2 steps + 1)^2 triangles.
void add_rounded_box(Surface& surface, const Vec3d& lower, const Vec3d& upper, double radius,
                     int steps);

/// A point of a profile that turns around the +Y axis: distance from the axis, height.
struct ProfilePoint {
  double radius = 0;
  double height = 0;
};

/// Turns a profile (bottom to top for an outside surface) around the vertical axis through
/// `centre`, in `segments` facets with smooth normals around. Points of radius 0 close the end.
void add_lathe(Surface& surface, const Vec3d& centre, const std::vector<ProfilePoint>& profile,
               int segments);

/// Closed upright cylinder.
void add_cylinder(Surface& surface, const Vec3d& foot, double radius, double height, int segments);

}  // namespace lightbatch::generate
