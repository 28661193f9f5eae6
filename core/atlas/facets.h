#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/atlas/weld.h"

namespace lightbatch::atlas {

/// Connected coplanar triangles: the pieces that charts are made of, so that a flat wall is never
/// cut. Triangles too thin to have a normal belong to the facet of a neighbour.
struct Facets {
  std::vector<std::uint32_t> of;       // triangle -> facet
  std::vector<std::uint32_t> first;    // facet -> place in members; one more at the end
  std::vector<std::uint32_t> members;  // triangles
  std::vector<Vec3d> normals;          // of the largest triangle
  std::vector<double> areas;

  std::uint32_t size() const { return static_cast<std::uint32_t>(areas.size()); }
  std::span<const std::uint32_t> triangles(std::uint32_t facet) const {
    return std::span(members).subspan(first[facet], first[facet + 1] - first[facet]);
  }
};

/// Normals of a facet's triangles lie within this angle of its largest one, rounding aside.
constexpr double kCoplanarAngle = 0.0035;  // 0.2 degrees

Facets find_facets(const Mesh& mesh);

}  // namespace lightbatch::atlas
