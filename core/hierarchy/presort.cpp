// Stable radix sort by centre, least significant digit first.

#include <algorithm>
#include <array>
#include <utility>

#include "core/hierarchy/records.h"

namespace lightbatch::hierarchy {
namespace {

struct Keyed {
  std::uint32_t key;
  std::uint32_t place;
};

constexpr int kBits = 8;
constexpr std::size_t kDigits = std::size_t{1} << kBits;
constexpr std::size_t kPasses = 32 / kBits;

using Counts = std::array<std::array<std::uint32_t, kDigits>, kPasses>;

std::size_t digit(std::uint32_t key, std::size_t pass) {
  return (key >> (kBits * pass)) & (kDigits - 1);
}

void sort_axis(std::span<const Record> records, std::size_t axis, Record* list, Keyed* from,
               Keyed* to) {
  Counts counts{};
  for (std::size_t i = 0; i < records.size(); ++i) {
    const std::uint32_t key = ordered_bits(records[i].key(axis));
    from[i] = {key, static_cast<std::uint32_t>(i)};
    for (std::size_t pass = 0; pass < kPasses; ++pass) ++counts[pass][digit(key, pass)];
  }
  for (std::size_t pass = 0; pass < kPasses; ++pass) {
    std::array<std::uint32_t, kDigits>& places = counts[pass];
    if (places[digit(from[0].key, pass)] == records.size()) continue;  // all the same
    std::uint32_t sum = 0;
    for (std::uint32_t& place : places) sum += std::exchange(place, sum);
    for (std::size_t i = 0; i < records.size(); ++i) {
      to[places[digit(from[i].key, pass)]++] = from[i];
    }
    std::swap(from, to);
  }
  for (std::size_t i = 0; i < records.size(); ++i) list[i] = records[from[i].place];
}

}  // namespace

void presort(std::span<const Record> records, const std::array<Record*, 3>& lists,
             const std::array<Record*, 3>& spare) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    auto* pairs = reinterpret_cast<Keyed*>(spare[axis]);
    sort_axis(records, axis, lists[axis], pairs, pairs + records.size());
  }
}

}  // namespace lightbatch::hierarchy
