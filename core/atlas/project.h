#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/atlas/weld.h"

namespace lightbatch::atlas {

/// A chart flattened along its best axis into its smallest rectangle; in metres of the shape, so
/// it holds for every density.
struct FlatChart {
  std::vector<std::uint32_t> triangles;  // of the mesh
  Vec3d axis;                            // unit
  Vec3d u, v;  // rows of the map, stretch included: (dot(u, p) - u0, dot(v, p) - v0)
  double u0 = 0, v0 = 0;
  double width = 0, height = 0;  // of the rectangle
  double area = 0;               // of the surface
  double flat_area = 0;          // of its image
  double outline = 0;            // sum over border edges of (|du| + |dv|) / 2
  double least = 1, most = 1;    // singular values of the map over the triangles
  bool coplanar = false;         // then the map is a similarity: least = most = 1

  Vec2d map(const Vec3d& p) const { return {dot(u, p) - u0, dot(v, p) - v0}; }
};

/// Reused between charts.
struct ProjectScratch {
  std::vector<std::uint32_t> stamp;  // per point: last chart that saw it
  std::uint32_t stamps = 0;
  std::vector<Vec2d> points;
};

/// `hint`: an axis known to be fair. `chart_of` (per mesh triangle) tells border edges from inner
/// ones; the chart's triangles have equal values there.
FlatChart project_chart(const Mesh& mesh, std::vector<std::uint32_t> triangles, const Vec3d& hint,
                        std::span<const std::uint32_t> chart_of, ProjectScratch& scratch);

/// Texels of the bilinear footprint at a density (texels per metre of the shape) when no side may
/// exceed max_side: an estimate between the image's own outline and its rectangle.
double footprint_estimate(const FlatChart& chart, double density, int max_side);

}  // namespace lightbatch::atlas
