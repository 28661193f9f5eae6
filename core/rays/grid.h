#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/math/aabb.h"

namespace lightbatch::rays {

/// How a box is cut into cells of one size. A point lies in the cell that cell_of() says: it is
/// monotone in floats, so a box and a point in it always have a cell in common.
struct GridLayout {
  float low[3];
  float width[3];     // of a cell; 0 where the box is flat
  float per_unit[3];  // cells in a unit of length
  std::uint32_t cells[3];

  /// About `count` cells, near to cubes.
  GridLayout(const Aabb& box, float count);

  std::uint32_t cell_of(std::size_t axis, float x) const {
    const float place = (x - low[axis]) * per_unit[axis];
    const auto last = static_cast<float>(cells[axis] - 1);
    return static_cast<std::uint32_t>(place > 0 ? std::min(place, last) : 0.0f);
  }
  std::uint32_t cell_count() const { return cells[0] * cells[1] * cells[2]; }
};

/// The other kind of node: a regular grid in place of child boxes, over the leaves of the subtree
/// that it stands for (G. Mueller, D. W. Fellner: Hybrid Scene Structuring with Application to Ray
/// Tracing, ICVC 1999). As stored: the layout, where the members of each cell begin (cell_count() +
/// 1 numbers, x fastest), the members (references to leaves).
struct Grid {
  GridLayout layout;

  const std::uint32_t* starts() const { return reinterpret_cast<const std::uint32_t*>(this + 1); }
  const std::uint32_t* members() const { return starts() + layout.cell_count() + 1; }
};

/// A leaf of the casting tree, to be put into a grid.
struct GridMember {
  Aabb box;
  std::uint32_t triangles = 0;
  std::uint32_t word = 0;
};

/// The cheapest of a few layouts, and what a ray through the box is expected to cost, times the
/// box's area (see casting_costs.h).
struct GridPlan {
  GridLayout layout;
  float cost;
};
GridPlan plan_grid(const Aabb& box, std::span<const GridMember> members);
/// No grid over so many leaves costs less.
float least_grid_cost(const Aabb& box, std::uint32_t leaves);
/// What follows the layout in memory.
std::vector<std::uint32_t> fill_grid(const GridLayout& layout, std::span<const GridMember> members);

}  // namespace lightbatch::rays
