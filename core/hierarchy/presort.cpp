// Stable radix sort by centre, least significant digit first, over the bits in which keys differ.

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <type_traits>
#include <utility>

#include "core/hierarchy/records.h"

namespace lightbatch::hierarchy {
namespace {

struct Keyed {
  std::uint32_t key;  // above the least
  std::uint32_t place;
};

constexpr std::uint32_t kMostBits = 11;  // of a digit
constexpr std::uint32_t kFewBits = 8;    // where records are fewer than digits of kMostBits

struct KeyRange {
  std::array<float, 3> least, most;
};

KeyRange key_range(std::span<const Record> records) {
  KeyRange range;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    range.least[axis] = range.most[axis] = records[0].key(axis);
  }
  for (const Record& record : records) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      range.least[axis] = std::min(range.least[axis], record.key(axis));
      range.most[axis] = std::max(range.most[axis], record.key(axis));
    }
  }
  return range;
}

/// How keys are cut.
struct Digits {
  std::uint32_t least, bits;  // of the keys; of a digit

  template <std::size_t kPass>
  std::size_t of(std::uint32_t key) const {
    return key >> (kPass * bits) & ((1u << bits) - 1);
  }
};

template <std::size_t... kPass>
void sort_axis(std::span<const Record> records, std::size_t axis, const Digits& digits,
               Record* list, Keyed* from, Keyed* to, std::index_sequence<kPass...>) {
  std::uint32_t counts[sizeof...(kPass)][1u << kMostBits];
  (std::fill_n(counts[kPass], std::size_t{1} << digits.bits, 0u), ...);
  for (std::size_t i = 0; i < records.size(); ++i) {
    const std::uint32_t key = ordered_bits(records[i].key(axis)) - digits.least;
    from[i] = {key, static_cast<std::uint32_t>(i)};
    (++counts[kPass][digits.of<kPass>(key)], ...);
  }
  const auto move_by = [&]<std::size_t kOne>(std::integral_constant<std::size_t, kOne>) {
    std::uint32_t* const places = counts[kOne];
    std::uint32_t sum = 0;
    for (std::size_t d = 0; d < std::size_t{1} << digits.bits; ++d) {
      sum += std::exchange(places[d], sum);
    }
    for (std::size_t i = 0; i < records.size(); ++i) {
      to[places[digits.of<kOne>(from[i].key)]++] = from[i];
    }
    std::swap(from, to);
  };
  (move_by(std::integral_constant<std::size_t, kPass>()), ...);
  for (std::size_t i = 0; i < records.size(); ++i) list[i] = records[from[i].place];
}

void sort_axis(std::span<const Record> records, std::size_t axis, const KeyRange& range,
               Record* list, Keyed* from, Keyed* to) {
  const std::uint32_t least = ordered_bits(range.least[axis]);
  const auto bits =
      static_cast<std::uint32_t>(std::bit_width(ordered_bits(range.most[axis]) - least));
  const std::uint32_t limit = records.size() < (1u << kMostBits) ? kFewBits : kMostBits;
  const std::uint32_t passes = std::max((bits + limit - 1) / limit, 1u);
  const Digits digits{least, (bits + passes - 1) / passes};
  switch (passes) {
    case 1:
      return sort_axis(records, axis, digits, list, from, to, std::make_index_sequence<1>());
    case 2:
      return sort_axis(records, axis, digits, list, from, to, std::make_index_sequence<2>());
    case 3:
      return sort_axis(records, axis, digits, list, from, to, std::make_index_sequence<3>());
    default:
      return sort_axis(records, axis, digits, list, from, to, std::make_index_sequence<4>());
  }
}

}  // namespace

void presort(std::span<const Record> records, const std::array<Record*, 3>& lists,
             const std::array<Record*, 3>& spare) {
  const KeyRange range = key_range(records);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    auto* pairs = reinterpret_cast<Keyed*>(spare[axis]);
    sort_axis(records, axis, range, lists[axis], pairs, pairs + records.size());
  }
}

}  // namespace lightbatch::hierarchy
