#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/math/aabb.h"

namespace lightbatch::hierarchy {

/// One primitive in a sorted list, box and all, so that sweeps and partitions never look anything
/// up. Upper planes are negated: the union of boxes is one vector minimum.
struct alignas(32) Record {
  float lower[3];
  std::uint32_t tagged_id;  // id | kTag: an ordinary float to vector code that computes on it
  float negated_upper[3];
  std::uint32_t one;

  static constexpr std::uint32_t kTag = 0x40000000u;
  std::uint32_t id() const { return tagged_id & ~kTag; }
  /// Twice the box centre.
  float key(std::size_t axis) const { return lower[axis] - negated_upper[axis]; }
};
static_assert(sizeof(Record) == 32);

/// Fills lists[axis] with all primitives, sorted by centre on the axis, ties by index. `spare`
/// holds as much again as the lists and is overwritten.
void presort(std::span<const Aabb> boxes, const std::array<Record*, 3>& lists,
             const std::array<Record*, 3>& spare);

}  // namespace lightbatch::hierarchy
