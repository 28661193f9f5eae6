#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/math/aabb.h"

namespace lightbatch::hierarchy {

/// One primitive in a list, box and all, so that sweeps and partitions never look anything up.
/// Upper planes are negated: the union of boxes is one vector minimum.
struct alignas(32) Record {
  float lower[3];
  std::uint32_t tagged_id;  // id | kTag: an ordinary float to vector code that computes on it
  float negated_upper[3];
  std::uint32_t one;

  static constexpr std::uint32_t kTag = 0x40000000u;
  static Record of(const Aabb& box, std::uint32_t id) {
    return {{box.lower.x, box.lower.y, box.lower.z},
            id | kTag,
            {-box.upper.x, -box.upper.y, -box.upper.z},
            0x3f800000u};
  }
  std::uint32_t id() const { return tagged_id & ~kTag; }
  /// Twice the box centre, the sort key.
  float key(std::size_t axis) const { return lower[axis] - negated_upper[axis]; }
};
static_assert(sizeof(Record) == 32);

/// Unsigned order of the result is the order of the floats, -0 and 0 the same.
inline std::uint32_t ordered_bits(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value + 0.0f);
  return (bits & 0x80000000u) != 0 ? ~bits : bits | 0x80000000u;
}

/// Fills lists[axis] with the records, which lie in the order of their ids, sorted by centre on the
/// axis, ties by id. `spare` holds as much again as the lists and is overwritten.
void presort(std::span<const Record> records, const std::array<Record*, 3>& lists,
             const std::array<Record*, 3>& spare);

}  // namespace lightbatch::hierarchy
