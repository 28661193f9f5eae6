// Stable radix sort by centre, least significant digit first, on three axes at once. Chunks have a
// fixed number, not one a thread; so every element's place is a function of the input.

#include <algorithm>
#include <bit>
#include <vector>

#include "core/base/parallel.h"
#include "core/hierarchy/records.h"
#include "core/hierarchy/split_rule.h"

namespace lightbatch::hierarchy {
namespace {

struct Keyed {
  std::uint32_t key;
  std::uint32_t id;
};

constexpr int kBits = 11;
constexpr std::size_t kDigits = std::size_t{1} << kBits;
constexpr std::size_t kSmall = 16384;
constexpr std::size_t kAhead = 16;

/// Unsigned order of the result is the order of the floats.
std::uint32_t ordered_bits(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return (bits & 0x80000000u) != 0 ? ~bits : bits | 0x80000000u;
}

Record make_record(const Aabb& box, std::uint32_t id) {
  return {{box.lower.x, box.lower.y, box.lower.z},
          id | Record::kTag,
          {-box.upper.x, -box.upper.y, -box.upper.z},
          0x3f800000u};
}

class Presort {
 public:
  Presort(std::span<const Aabb> boxes, const std::array<Record*, 3>& lists,
          const std::array<Record*, 3>& spare)
      : boxes_(boxes),
        lists_(lists),
        chunks_(boxes.size() < kSmall || thread_count() == 1 ? 1 : 4),
        counts_((chunks_ == 1 ? 9 : 3 * chunks_) * kDigits) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      auto* pairs = reinterpret_cast<Keyed*>(spare[axis]);
      pairs_[0][axis] = pairs;
      pairs_[1][axis] = pairs + boxes.size();
    }
  }

  void run() {
    if (chunks_ == 1) count_all();
    pass(
        [&](std::size_t axis, std::size_t i) {
          return Keyed{ordered_bits(centre_key(boxes_[i], axis)), static_cast<std::uint32_t>(i)};
        },
        0,
        [&](std::size_t axis, std::size_t place, const Keyed& k) { pairs_[0][axis][place] = k; });
    pass([&](std::size_t axis, std::size_t i) { return pairs_[0][axis][i]; }, kBits,
         [&](std::size_t axis, std::size_t place, const Keyed& k) { pairs_[1][axis][place] = k; });
    pass(
        [&](std::size_t axis, std::size_t i) {
          __builtin_prefetch(&boxes_[pairs_[1][axis][std::min(i + kAhead, boxes_.size() - 1)].id]);
          return pairs_[1][axis][i];
        },
        2 * kBits,
        [&](std::size_t axis, std::size_t place, const Keyed& k) {
          lists_[axis][place] = make_record(boxes_[k.id], k.id);
        });
  }

 private:
  /// With one chunk an element's digits are counted once, for the three passes.
  void count_all() {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::uint32_t* counts = counts_.data() + axis * kDigits;
      for (const Aabb& box : boxes_) {
        const std::uint32_t key = ordered_bits(centre_key(box, axis));
        ++counts[key & (kDigits - 1)];
        ++counts[3 * kDigits + (key >> kBits & (kDigits - 1))];
        ++counts[6 * kDigits + (key >> 2 * kBits)];
      }
    }
  }

  template <typename Read, typename Write>
  void pass(Read read, int shift, Write write) {
    const auto digit = [&](const Keyed& k) { return (k.key >> shift) & (kDigits - 1); };
    const std::size_t pass_index = static_cast<std::size_t>(shift / kBits);
    std::uint32_t* const all_counts =
        counts_.data() + (chunks_ == 1 ? 3 * kDigits * pass_index : 0);
    const auto each_chunk = [&](auto body) {
      parallel_for(3 * chunks_, 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t task = first; task < last; ++task) {
          const std::size_t axis = task / chunks_, chunk = task % chunks_;
          body(axis, all_counts + task * kDigits, chunk * boxes_.size() / chunks_,
               (chunk + 1) * boxes_.size() / chunks_);
        }
      });
    };
    if (chunks_ > 1) {
      each_chunk([&](std::size_t axis, std::uint32_t* counts, std::size_t begin, std::size_t end) {
        std::fill_n(counts, kDigits, 0u);
        for (std::size_t i = begin; i < end; ++i) ++counts[digit(read(axis, i))];
      });
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::uint32_t sum = 0;
      std::uint32_t* counts = all_counts + axis * chunks_ * kDigits;
      for (std::size_t d = 0; d < kDigits; ++d) {
        for (std::size_t chunk = 0; chunk < chunks_; ++chunk) {
          const std::uint32_t count = counts[chunk * kDigits + d];
          counts[chunk * kDigits + d] = sum;
          sum += count;
        }
      }
    }
    each_chunk([&](std::size_t axis, std::uint32_t* places, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Keyed k = read(axis, i);
        write(axis, places[digit(k)]++, k);
      }
    });
  }

  std::span<const Aabb> boxes_;
  const std::array<Record*, 3>& lists_;
  std::size_t chunks_;
  std::vector<std::uint32_t> counts_;
  std::array<std::array<Keyed*, 3>, 2> pairs_{};
};

}  // namespace

void presort(std::span<const Aabb> boxes, const std::array<Record*, 3>& lists,
             const std::array<Record*, 3>& spare) {
  Presort(boxes, lists, spare).run();
}

}  // namespace lightbatch::hierarchy
