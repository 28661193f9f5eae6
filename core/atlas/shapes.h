#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/math/mat.h"
#include "core/scene/scene.h"

namespace lightbatch::atlas {

/// One use of a shape in the scene.
struct Instance {
  double scale = 1;                      // size of this use over the size of the shape's first one
  Affine move;                           // from the shape's first use to this one
  std::vector<std::uint32_t> triangles;  // shape triangle -> scene triangle, or kNone
  /// Corner k of a shape triangle is corner order[k] here (mirroring exchanges two).
  std::array<std::uint8_t, 3> order{0, 1, 2};
};

/// The lit triangles of one node (all primitives together, so that they weld), charted once for
/// all nodes that show the same primitives rigidly moved, mirrored or uniformly scaled.
struct Shape {
  std::vector<std::uint32_t> triangles;  // scene triangles of the first use
  std::vector<Instance> instances;       // [0] is the first use, scale 1
  Affine frame;                          // of the first use: its axes are tried as box axes
};

/// Deterministic: shapes in the order of their first object. A node whose triangles differ from
/// the shape's (a sliver that rounding made degenerate) keeps what is common; the rest becomes a
/// shape of its own.
std::vector<Shape> find_shapes(const scene::Scene& scene, const std::vector<std::uint8_t>& lit);

}  // namespace lightbatch::atlas
