#include "core/base/random.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <set>

namespace lightbatch {
namespace {

TEST(Random, IsSplitmix64) {
  // First outputs for seed 1234567 (reference implementation of Vigna, prng.di.unimi.it).
  Random random(1234567);
  EXPECT_EQ(random.next_u64(), 6457827717110365317ull);
  EXPECT_EQ(random.next_u64(), 3203168211198807973ull);
  EXPECT_EQ(random.next_u64(), 9817491932198370423ull);
}

TEST(Random, StaysInItsRange) {
  Random random(1);
  for (int i = 0; i < 100'000; ++i) {
    const float f = random.next_float();
    const double d = random.next_double();
    ASSERT_TRUE(f >= 0 && f < 1);
    ASSERT_TRUE(d >= 0 && d < 1);
    ASSERT_LT(random.below(7), 7u);
    ASSERT_EQ(random.below(1), 0u);
  }
}

TEST(Random, IsUniform) {
  constexpr int kDraws = 200'000, kBins = 100;
  std::array<int, kBins> of_double{}, of_below{};
  Random random(item_seed(3, 5));
  double sum = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double value = random.next_double();
    sum += value;
    ++of_double[static_cast<std::size_t>(value * kBins)];
    ++of_below[random.below(kBins)];
  }
  // Mean: sigma 1 / sqrt(12 n) = 6.5e-4; five sigma.
  EXPECT_NEAR(sum / kDraws, 0.5, 3.3e-3);
  // Chi-squared of 99 degrees of freedom exceeds 170 once in 10^5 seeds.
  const double expected = static_cast<double>(kDraws) / kBins;
  for (const auto& bins : {of_double, of_below}) {
    double chi_squared = 0;
    for (const int count : bins) chi_squared += (count - expected) * (count - expected) / expected;
    EXPECT_LT(chi_squared, 170);
  }
}

TEST(ItemSeed, SeparatesJobsItemsAndStreams) {
  std::set<std::uint64_t> seeds;
  for (std::uint64_t job = 0; job < 20; ++job) {
    for (std::uint64_t item = 0; item < 50; ++item) {
      for (std::uint64_t stream = 0; stream < 4; ++stream) {
        seeds.insert(item_seed(job, item, stream));
      }
    }
  }
  EXPECT_EQ(seeds.size(), 20u * 50 * 4);
}

TEST(MixBits, EachInputBitFlipsHalfOfTheOutput) {
  for (int bit = 0; bit < 64; ++bit) {
    double flipped = 0;
    Random random(static_cast<std::uint64_t>(bit));
    for (int i = 0; i < 1000; ++i) {
      const std::uint64_t value = random.next_u64();
      flipped += std::popcount(mix_bits(value) ^ mix_bits(value ^ (1ull << bit)));
    }
    // Mean of 1000 sums of 64 fair coins: sigma 4 / sqrt(1000) = 0.13; six sigma.
    EXPECT_NEAR(flipped / 1000, 32, 0.8) << "bit " << bit;
  }
}

}  // namespace
}  // namespace lightbatch
