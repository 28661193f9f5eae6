#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace lightbatch::atlas {

/// A set of texels in a rectangle, one bit each.
struct Mask {
  int width = 0, height = 0;
  std::size_t stride = 0;  // words per row
  std::vector<std::uint64_t> bits;

  Mask() = default;
  Mask(int w, int h)
      : width(w),
        height(h),
        stride((static_cast<std::size_t>(w) + 63) / 64),
        bits(stride * static_cast<std::size_t>(h), 0) {}

  bool get(int x, int y) const {
    return (row(y)[static_cast<std::size_t>(x) / 64] >> (x % 64) & 1) != 0;
  }
  std::uint64_t* row(int y) { return bits.data() + stride * static_cast<std::size_t>(y); }
  const std::uint64_t* row(int y) const {
    return bits.data() + stride * static_cast<std::size_t>(y);
  }
  /// Sets texels first..last of a row.
  void set_span(int y, int first, int last);
  /// Adds another mask with its corner at (x, y); must fit.
  void add(const Mask& other, int x, int y);
  std::int64_t count() const;
  bool is_full() const { return count() == std::int64_t{width} * height; }
  bool operator==(const Mask&) const = default;
};

/// The mask turned counter-clockwise by quarter turns (0..3).
Mask turned(const Mask& mask, int quarters);

/// One bit per cell of `cell` x `cell` texels (a power of two): set when any texel is.
Mask coarsened(const Mask& mask, int cell);

}  // namespace lightbatch::atlas
