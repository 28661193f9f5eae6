#pragma once

#include <algorithm>
#include <limits>

#include "core/math/vec.h"

namespace lightbatch {

/// Axis-aligned bounding box. Empty: lower > upper.
template <typename T>
struct BasicAabb {
  Vec3<T> lower{std::numeric_limits<T>::infinity(), std::numeric_limits<T>::infinity(),
                std::numeric_limits<T>::infinity()};
  Vec3<T> upper{-std::numeric_limits<T>::infinity(), -std::numeric_limits<T>::infinity(),
                -std::numeric_limits<T>::infinity()};

  constexpr void add(const Vec3<T>& p) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  constexpr void add(const BasicAabb& b) {
    lower = {std::min(lower.x, b.lower.x), std::min(lower.y, b.lower.y),
             std::min(lower.z, b.lower.z)};
    upper = {std::max(upper.x, b.upper.x), std::max(upper.y, b.upper.y),
             std::max(upper.z, b.upper.z)};
  }
  constexpr bool is_empty() const { return lower.x > upper.x; }
  constexpr Vec3<T> extent() const { return is_empty() ? Vec3<T>{} : upper - lower; }
  constexpr Vec3<T> centre() const { return (lower + upper) * T(0.5); }
  T diagonal() const { return length(extent()); }
  /// k < 8; bits of k: upper side in x, y, z.
  constexpr Vec3<T> corner(unsigned k) const {
    return {(k & 1u) != 0 ? upper.x : lower.x, (k & 2u) != 0 ? upper.y : lower.y,
            (k & 4u) != 0 ? upper.z : lower.z};
  }
  /// Surface area; 0 when empty.
  constexpr T area() const {
    const Vec3<T> e = extent();
    return T(2) * (e.x * e.y + e.y * e.z + e.z * e.x);
  }
  constexpr bool overlaps(const BasicAabb& b) const {
    return lower.x <= b.upper.x && b.lower.x <= upper.x && lower.y <= b.upper.y &&
           b.lower.y <= upper.y && lower.z <= b.upper.z && b.lower.z <= upper.z;
  }
  constexpr bool contains(const Vec3<T>& p) const {
    return lower.x <= p.x && p.x <= upper.x && lower.y <= p.y && p.y <= upper.y && lower.z <= p.z &&
           p.z <= upper.z;
  }
  constexpr bool operator==(const BasicAabb&) const = default;
};

using Aabb = BasicAabb<float>;
using Aabbd = BasicAabb<double>;

}  // namespace lightbatch
