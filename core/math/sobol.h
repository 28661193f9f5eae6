#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/math/vec.h"

namespace lightbatch {

/// Owen-scrambled Sobol points: every prefix of 2^k points of a dimension is stratified in 2^k
/// slots, and dimensions 0 and 1 together are a (0, 2)-sequence; any seed gives an independent,
/// unbiased scramble.
///
/// Sobol 1967, direction numbers of Joe and Kuo 2008 (new-joe-kuo-6.21201); scrambling by hash:
/// Laine and Karras 2011, Burley 2020 (Practical Hash-based Owen Scrambling), with the constants
/// of Vegdahl 2021. The generator matrices are kept bit-reversed and applied a byte of the index
/// at a time (linear over XOR), so that one reversal per coordinate is left.
namespace sobol {

constexpr std::size_t kDimensions = 8;

/// Bit-reversed coordinate of each byte of the index: [dimension][byte place][byte].
using Table = std::array<std::array<std::array<std::uint32_t, 256>, 4>, kDimensions>;
extern const Table kReversed;

constexpr std::uint32_t reverse_bits(std::uint32_t x) {
  x = __builtin_bswap32(x);
  x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
  x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
  return ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
}

/// Nested uniform scramble of a bit-reversed number: bit i of the result depends on bits <= i.
constexpr std::uint32_t scramble_reversed(std::uint32_t x, std::uint32_t seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

constexpr std::uint32_t hash_seed(std::uint32_t seed, std::uint32_t dimension) {
  std::uint32_t x = seed ^ (dimension * 0x9e3779b9u + 0x7f4a7c15u);
  x ^= x >> 16;
  x *= 0x21f0aaadu;
  x ^= x >> 15;
  x *= 0x735a2d97u;
  return x ^ (x >> 15);
}

/// [0, 1), 24 bits.
constexpr float to_unit(std::uint32_t x) { return static_cast<float>(x >> 8) * 0x1p-24f; }

inline std::uint32_t reversed_point(std::size_t dimension, std::uint32_t index) {
  const auto& t = kReversed[dimension];
  return t[0][index & 255u] ^ t[1][(index >> 8) & 255u] ^ t[2][(index >> 16) & 255u] ^
         t[3][index >> 24];
}

}  // namespace sobol

/// Two dimensions, for hemisphere directions and points of areas.
class OwenSobol2 {
 public:
  explicit OwenSobol2(std::uint32_t seed)
      : seed_x_(sobol::hash_seed(seed, 0)), seed_y_(sobol::hash_seed(seed, 1)) {}

  Vec2f point(std::uint32_t index) const {
    using namespace sobol;
    return {to_unit(reverse_bits(scramble_reversed(index, seed_x_))),
            to_unit(reverse_bits(scramble_reversed(reversed_point(1, index), seed_y_)))};
  }

 private:
  std::uint32_t seed_x_;
  std::uint32_t seed_y_;
};

/// Up to eight dimensions; for more, use several with different seeds.
class OwenSobol8 {
 public:
  explicit OwenSobol8(std::uint32_t seed) {
    for (std::size_t d = 0; d < sobol::kDimensions; ++d) {
      seeds_[d] = sobol::hash_seed(seed, static_cast<std::uint32_t>(d));
    }
  }

  /// dimension < 8.
  float coordinate(std::uint32_t index, std::size_t dimension) const {
    using namespace sobol;
    return to_unit(
        reverse_bits(scramble_reversed(reversed_point(dimension, index), seeds_[dimension])));
  }
  /// Dimensions d and d + 1.
  Vec2f pair(std::uint32_t index, std::size_t d) const {
    return {coordinate(index, d), coordinate(index, d + 1)};
  }

 private:
  std::array<std::uint32_t, sobol::kDimensions> seeds_{};
};

}  // namespace lightbatch
