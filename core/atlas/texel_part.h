#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/atlas/grid.h"
#include "core/math/vec.h"

namespace lightbatch::atlas {

/// The part of a triangle that lies in one texel, by weights of corners 1 and 2: on triangles that
/// collapsed to a line or point on the page, too.
class TexelPart {
 public:
  TexelPart(const GridTriangle& triangle, std::int32_t x, std::int32_t y);

  /// Maps the unit square to the part, equal areas to equal areas.
  Vec2f at(Vec2f square) const;

 private:
  /// A line across the part, at a corner of it: the lines between two are between theirs.
  struct Chord {
    double at = 0;            // along the axis
    double from = 0, to = 0;  // across
    double area = 0;          // before it
    double width() const { return to - from; }
  };
  static constexpr std::size_t kMostCorners = 8;
  struct Corners {
    std::array<Vec2d, kMostCorners> corner;  // convex
    std::size_t count = 0;
    /// Keeps what is at least 0 of a function that is linear in the weights.
    void keep(double at_0, double at_1, double at_2);
    double twice_area() const;
  };
  void sweep(const Corners& corners);

  Vec2d axis_{1, 0};
  std::array<Chord, kMostCorners> chord_;
  std::size_t count_ = 0;
};

}  // namespace lightbatch::atlas
