#pragma once

#include <cstdint>

namespace lightbatch {

/// 64-bit finaliser (splitmix64, Steele, Lea and Flood 2014): every output bit depends on every
/// input bit.
constexpr std::uint64_t mix_bits(std::uint64_t x) {
  x ^= x >> 30;
  x *= 0xbf58476d1ce4e5b9ULL;
  x ^= x >> 27;
  x *= 0x94d049bb133111ebULL;
  x ^= x >> 31;
  return x;
}

/// Seed of one item of one job: random numbers depend on (job, item) alone, never on a thread.
constexpr std::uint64_t item_seed(std::uint64_t job_seed, std::uint64_t item,
                                  std::uint64_t stream = 0) {
  return mix_bits(mix_bits(job_seed + 0x9e3779b97f4a7c15ULL * (stream + 1)) ^
                  (item * 0xd1342543de82ef95ULL + 0x2545f4914f6cdd1dULL));
}

/// Counter-based generator (splitmix64): cheap, any seed is good.
class Random {
 public:
  explicit constexpr Random(std::uint64_t seed) : state_(seed) {}

  constexpr std::uint64_t next_u64() {
    state_ += 0x9e3779b97f4a7c15ULL;
    return mix_bits(state_);
  }
  constexpr std::uint32_t next_u32() { return static_cast<std::uint32_t>(next_u64() >> 32); }
  /// Uniform in [0, 1), 24 bits.
  constexpr float next_float() { return static_cast<float>(next_u64() >> 40) * 0x1p-24f; }
  /// Uniform in [0, 1), 53 bits.
  constexpr double next_double() { return static_cast<double>(next_u64() >> 11) * 0x1p-53; }
  /// Uniform in [0, bound); bound > 0. Bias below bound / 2^64.
  constexpr std::uint64_t below(std::uint64_t bound) {
    __extension__ using Wide = unsigned __int128;
    return static_cast<std::uint64_t>((static_cast<Wide>(next_u64()) * bound) >> 64);
  }

 private:
  std::uint64_t state_;
};

}  // namespace lightbatch
