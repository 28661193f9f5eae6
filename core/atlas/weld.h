#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/math/vec.h"
#include "core/scene/scene.h"

namespace lightbatch::atlas {

/// Triangles of one shape with neighbours. Half-edge 3 t + k runs from corner k of triangle t to
/// the next corner.
struct Mesh {
  std::vector<Vec3d> points;                          // welded
  std::vector<std::array<std::uint32_t, 3>> corners;  // per triangle, into points
  std::vector<std::uint32_t> source;                  // place in the list that was welded
  std::vector<std::uint32_t> twin;                    // per half-edge: the neighbour's, or kNone
  std::vector<Vec3d> normals;                         // unit
  std::vector<double> areas;                          // > 0
  /// Angle in radians that rounding of the positions may have turned the normal by.
  std::vector<float> slack;

  std::uint32_t size() const { return static_cast<std::uint32_t>(corners.size()); }
};

/// Above this slack a triangle's own normal says nothing: it follows its neighbours.
constexpr float kNoNormal = 0.1f;

/// Welds equal positions (exact bits), drops triangles without area and pairs edges: opposite
/// directions only; where more than two triangles meet, the pair with the smallest fold first.
/// Edges with more than 32 triangles stay open.
Mesh weld(const scene::Scene& scene, std::span<const std::uint32_t> triangles);

}  // namespace lightbatch::atlas
