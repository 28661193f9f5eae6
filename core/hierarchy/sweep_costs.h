// What splits cost, a vector at a time; included by sweep_impl.h only.

constexpr std::uint32_t kWholeSweep = 64;  // nodes up to here are swept without blocks
constexpr std::uint32_t kSmallBlock = 16;  // block size of nodes up to kManySmall
constexpr std::uint32_t kManySmall = 1024;
constexpr std::uint32_t kLargeBlock = 64;
constexpr std::size_t kMargin = 16;  // records before and after a list that may be read

/// What the blocks of one list know. Index b: block b, positions starts[b] to starts[b + 1];
/// prefixes end before it, suffixes begin with it.
struct Blocks {
  std::vector<Record> boxes, prefix, suffix;
  std::vector<float> prefix_area, suffix_area;
  std::vector<std::uint32_t> starts;
  void resize(std::size_t n) {
    if (boxes.size() >= n) return;
    boxes.resize(n);
    prefix.resize(n + 1);
    suffix.resize(n + 1);
    prefix_area.resize(n + 1);
    suffix_area.resize(n + 1);
    starts.resize(n + 1);
  }
};
using NodeBlocks = std::array<Blocks, 3>;

/// The limits and the place of a sweep over part of a list.
struct SweepContext {
  std::uint32_t n;
  std::uint32_t axis;
  PositionRange range;
};

/// The split of a node of at most 64 whose positions cost `cost` at least; where[axis] has bit k
/// where position k + 1 does. Ties as Split::offer has them.
LB_INLINE Split nearest_to_middle(const std::array<std::uint64_t, 3>& where, float cost,
                                  std::uint32_t n) {
  const std::uint64_t any = where[0] | where[1] | where[2];
  const std::uint64_t low = any & ((std::uint64_t{1} << (n / 2)) - 1);
  const auto bit =
      static_cast<std::uint32_t>(low != 0 ? 63 - std::countl_zero(low) : std::countr_zero(any));
  const std::uint32_t axis = (where[0] >> bit & 1u) != 0 ? 0 : (where[1] >> bit & 1u) != 0 ? 1 : 2;
  return {cost, axis, bit + 1, tie_rank(bit + 1, n)};
}

/// Of r[0, count), count >= 1.
LB_INLINE V8f box_of(const Record* r, std::size_t count) {
  V8f even = load_box(r), odd = load_box(r + count - 1);
  std::size_t k = 1;
  for (; k + 1 < count; k += 2) {
    even = unite(load_box(r + k), even);
    odd = unite(load_box(r + k + 1), odd);
  }
  return unite(even, odd);
}

#ifdef LB_SWEEP_AVX512
#include "core/hierarchy/sweep_costs512.h"
#else
/// Offers every position strictly inside r[0, count), which begins at position `first` of its node;
/// `before` and `after` are the boxes of what lies outside.
LB_INLINE void sweep_inside(const Record* r, std::uint32_t count, std::uint32_t first, V8f before,
                            V8f after, const SweepContext& context, Split& best) {
  V4f right[kLargeBlock + 4];
  V8f box = after;
  for (std::uint32_t j = count - 1; j > 0; --j) {
    box = unite(load_box(r + j), box);
    right[j] = negated_extent(box);
  }
  for (std::uint32_t j = count; j < count + 3; ++j) right[j] = V4f{};
  box = before;
  const V4i steps{0, 1, 2, 3};
  for (std::uint32_t j = 1; j < count; j += 4) {
    V4f left[4];
    for (std::uint32_t i = 0; i < 4; ++i) {
      box = unite(load_box(r + std::min(j + i, count) - 1), box);
      left[i] = negated_extent(box);
    }
    const V4f left_area = areas_of(left[0], left[1], left[2], left[3]);
    const V4f right_area = areas_of(right[j], right[j + 1], right[j + 2], right[j + 3]);
    const std::uint32_t k = first + j;
    const V4f on_left = __builtin_convertvector(steps + static_cast<std::int32_t>(k), V4f);
    const V4f on_right =
        __builtin_convertvector(static_cast<std::int32_t>(context.n - k) - steps, V4f);
    const V4f cost = left_area * on_left + right_area * on_right;
    unsigned mask = mask4(cost <= best.cost) & ((1u << std::min(4u, count - j)) - 1);
    for (; mask != 0; mask &= mask - 1) {
      const auto i = static_cast<std::uint32_t>(std::countr_zero(mask));
      if (k + i < context.range.first || k + i > context.range.last) continue;
      best.offer(cost[i], context.axis, k + i, tie_rank(k + i, context.n));
    }
  }
}

/// The costs of all positions of three small lists, side by side: cost[j / 4][axis][i] is that of
/// position j + i, NaN beyond the last. Lowers `least`; returns the box.
LB_INLINE V8f whole_costs(const std::array<const Record*, 3>& r, std::uint32_t n, V4f (*cost)[3],
                          V4f& least) {
  V4f right[3][kWholeSweep + 4];
  V8f box[3];
  for (std::size_t a = 0; a < 3; ++a) {
    box[a] = load_box(r[a] + n - 1);
    right[a][n - 1] = negated_extent(box[a]);
    // Positions beyond the last one never compare as less.
    for (std::uint32_t j = n; j < n + 3; ++j) right[a][j] = infinite4() - infinite4();
  }
  for (std::uint32_t j = n - 2; j > 0; --j) {
    for (std::size_t a = 0; a < 3; ++a) {
      box[a] = unite(load_box(r[a] + j), box[a]);
      right[a][j] = negated_extent(box[a]);
    }
  }
  const V8f all = unite(load_box(r[0]), box[0]);
  for (std::size_t a = 0; a < 3; ++a) box[a] = load_box(r[a]);
  V4i on_left{1, 2, 3, 4};
  for (std::uint32_t j = 1; j < n; j += 4) {
    const V4f many_left = __builtin_convertvector(on_left, V4f);
    const V4f many_right = __builtin_convertvector(static_cast<std::int32_t>(n) - on_left, V4f);
    on_left += 4;
    for (std::size_t a = 0; a < 3; ++a) {
      V4f left[4];
      for (std::uint32_t i = 0; i < 4; ++i) {
        left[i] = negated_extent(box[a]);
        box[a] = unite(load_box(r[a] + std::min(j + i, n - 1)), box[a]);
      }
      const V4f sum =
          areas_of(left[0], left[1], left[2], left[3]) * many_left +
          areas_of(right[a][j], right[a][j + 1], right[a][j + 2], right[a][j + 3]) * many_right;
      cost[j / 4][a] = sum;
      least = sum < least ? sum : least;
    }
  }
  return all;
}

/// The cheapest split of a node of at most kWholeSweep; every position is allowed.
LB_INLINE Split cheapest(const std::array<const Record*, 3>& r, std::uint32_t n, V8f& box) {
  V4f cost[kWholeSweep / 4 + 1][3];
  V4f least = infinite4();
  box = whole_costs(r, n, cost, least);
  const float best = least_of(least);
  if (!(best < std::numeric_limits<float>::infinity())) return Split::middle(n);
  std::array<std::uint64_t, 3> where{};
  for (std::uint32_t j = 1; j < n; j += 4) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      where[axis] |= std::uint64_t{mask4(cost[j / 4][axis] == best)} << (j - 1);
    }
  }
  return nearest_to_middle(where, best, n);
}
#endif
