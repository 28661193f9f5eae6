#include "core/atlas/mask.h"

#include <algorithm>
#include <bit>

namespace lightbatch::atlas {

void Mask::set_span(int y, int first, int last) {
  std::uint64_t* words = row(y);
  const std::size_t a = static_cast<std::size_t>(first) / 64;
  const std::size_t b = static_cast<std::size_t>(last) / 64;
  const std::uint64_t from = ~std::uint64_t{0} << (first % 64);
  const std::uint64_t to = ~std::uint64_t{0} >> (63 - last % 64);
  if (a == b) {
    words[a] |= from & to;
    return;
  }
  words[a] |= from;
  for (std::size_t i = a + 1; i < b; ++i) words[i] = ~std::uint64_t{0};
  words[b] |= to;
}

void Mask::add(const Mask& other, int x, int y) {
  const std::size_t word = static_cast<std::size_t>(x) / 64;
  const int shift = x % 64;
  for (int r = 0; r < other.height; ++r) {
    std::uint64_t* to = row(y + r) + word;
    const std::uint64_t* from = other.row(r);
    for (std::size_t i = 0; i < other.stride; ++i) {
      if (from[i] == 0) continue;
      to[i] |= from[i] << shift;
      if (shift != 0 && from[i] >> (64 - shift) != 0) to[i + 1] |= from[i] >> (64 - shift);
    }
  }
}

std::int64_t Mask::count() const {
  std::int64_t sum = 0;
  for (const std::uint64_t word : bits) sum += std::popcount(word);
  return sum;
}

Mask turned(const Mask& mask, int quarters) {
  if (quarters == 0) return mask;
  const bool across = quarters % 2 == 1;
  Mask out(across ? mask.height : mask.width, across ? mask.width : mask.height);
  const int w = mask.width - 1, h = mask.height - 1;
  for (int y = 0; y < mask.height; ++y) {
    const std::uint64_t* words = mask.row(y);
    for (std::size_t i = 0; i < mask.stride; ++i) {
      for (std::uint64_t rest = words[i]; rest != 0; rest &= rest - 1) {
        const int x = static_cast<int>(i) * 64 + std::countr_zero(rest);
        const int u = quarters == 1 ? h - y : quarters == 2 ? w - x : y;
        const int v = quarters == 1 ? x : quarters == 2 ? h - y : w - x;
        out.row(v)[static_cast<std::size_t>(u) / 64] |= std::uint64_t{1} << (u % 64);
      }
    }
  }
  return out;
}

Mask coarsened(const Mask& mask, int cell) {
  if (cell == 1) return mask;
  Mask out((mask.width + cell - 1) / cell, (mask.height + cell - 1) / cell);
  const int shift = std::countr_zero(static_cast<unsigned>(cell));
  std::vector<std::uint64_t> band(mask.stride);
  for (int y = 0; y < out.height; ++y) {
    std::fill(band.begin(), band.end(), 0);
    for (int r = y * cell; r < std::min(mask.height, (y + 1) * cell); ++r) {
      for (std::size_t i = 0; i < mask.stride; ++i) band[i] |= mask.row(r)[i];
    }
    for (std::size_t i = 0; i < mask.stride; ++i) {
      for (std::uint64_t rest = band[i]; rest != 0;) {
        const int x = (static_cast<int>(i) * 64 + std::countr_zero(rest)) >> shift;
        out.row(y)[static_cast<std::size_t>(x) / 64] |= std::uint64_t{1} << (x % 64);
        const int next = ((x + 1) << shift) - static_cast<int>(i) * 64;
        rest = next >= 64 ? 0 : rest & (~std::uint64_t{0} << next);
      }
    }
  }
  return out;
}

}  // namespace lightbatch::atlas
