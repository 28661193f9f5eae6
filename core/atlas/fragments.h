#pragma once

#include <cstdint>
#include <vector>

#include "core/atlas/grid.h"
#include "core/atlas/texels.h"

namespace lightbatch::atlas {

/// A fragment with its texel.
struct PlacedFragment {
  std::int32_t x = 0, y = 0;
  Fragment fragment;
};

/// Appends the triangle's fragments in texel rows first_row .. end_row - 1. `surface`: its area in
/// m2.
void append_fragments(const GridTriangle& g, std::uint32_t triangle, double surface,
                      std::int32_t first_row, std::int32_t end_row,
                      std::vector<PlacedFragment>& out);

/// First and last texel row that holds fragments of the triangle.
struct RowRange {
  std::int32_t first = 0, last = 0;
};
RowRange texel_rows(const GridTriangle& g);

/// A triangle that collapsed to a line, seen along it: corners in order of their place t in [0, 1].
struct CollapsedTriangle {
  explicit CollapsedTriangle(const GridTriangle& g);
  /// Share of the triangle's surface before t.
  double share_before(double t) const;

  std::array<std::size_t, 3> order;  // corners by place
  double middle = 0;                 // place of the middle corner; the others are 0 and 1
  bool point = false;                // all corners in one place
};

}  // namespace lightbatch::atlas
