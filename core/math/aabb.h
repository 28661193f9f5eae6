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
  /// From a point to the nearest point of the box, 0 inside, and to the farthest; in the point's
  /// precision.
  template <typename P>
  P distance_to(const Vec3<P>& p) const {
    const auto [below, above] = beyond(p);
    const auto outside = [](P b, P a) { return std::max({b, a, P(0)}); };
    return length(
        Vec3<P>{outside(below.x, above.x), outside(below.y, above.y), outside(below.z, above.z)});
  }
  template <typename P>
  P farthest_from(const Vec3<P>& p) const {
    const auto [below, above] = beyond(p);
    const auto across = [](P b, P a) { return std::max(-b, -a); };
    return length(
        Vec3<P>{across(below.x, above.x), across(below.y, above.y), across(below.z, above.z)});
  }
  constexpr bool operator==(const BasicAabb&) const = default;

 private:
  /// How far a point is below the lower and above the upper sides.
  template <typename P>
  struct Beyond {
    Vec3<P> below, above;
  };
  template <typename P>
  Beyond<P> beyond(const Vec3<P>& p) const {
    const auto as = [](const Vec3<T>& v) {
      return Vec3<P>{static_cast<P>(v.x), static_cast<P>(v.y), static_cast<P>(v.z)};
    };
    return {as(lower) - p, p - as(upper)};
  }
};

using Aabb = BasicAabb<float>;
using Aabbd = BasicAabb<double>;

}  // namespace lightbatch
