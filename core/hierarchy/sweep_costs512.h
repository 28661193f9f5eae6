// What splits cost, with vectors of 64 bytes; included by sweep_costs.h only.
//
// One vector holds the box on the left and the box on the right, which grow towards each other.

constexpr std::uint32_t kAtOnce = 16;

/// Half areas on both sides of the positions 1 to count - 1 of a list.
class BothAreas {
 public:
  /// Of r[0, count), 2 <= count <= kLargeBlock, where `before` and `after` are the boxes of what
  /// lies outside. Up to kMargin records on either side are read, and do not matter.
  LB_INLINE BothAreas(const Record* r, std::uint32_t count, V8f before, V8f after) {
    chunks_ = (count - 1 + kAtOnce - 1) / kAtOnce;
    shift_ = chunks_ * kAtOnce + 1 - count;
    __m512 box = pair_of(before, after);
    // Of steps 0 to 15 in the order of eight: even ones, then odd ones, each left (L) and right
    // (R): L0 L2 L4 L6 R0 R2 R4 R6 L1 L3 L5 L7 R1 R3 R5 R7.
    const __m512i on_left =
        _mm512_setr_epi32(0, 8, 1, 9, 2, 10, 3, 11, 16, 24, 17, 25, 18, 26, 19, 27);
    const __m512i on_right =
        _mm512_setr_epi32(31, 23, 30, 22, 29, 21, 28, 20, 15, 7, 14, 6, 13, 5, 12, 4);
    for (std::uint32_t chunk = 0; chunk < chunks_; ++chunk) {
      const std::uint32_t step = chunk * kAtOnce;
      const Record *low = r + step, *high = r + count - 1 - step;
      const __m512 first = eight_steps(low, high, box);
      const __m512 second = step + 8 < count - 1 ? eight_steps(low + 8, high - 8, box) : first;
      left_[chunk] = _mm512_permutex2var_ps(first, on_left, second);
      right_[chunks_ - 1 - chunk] = _mm512_permutex2var_ps(first, on_right, second);
    }
  }

  std::uint32_t chunks() const { return chunks_; }

  /// What the positions from 1 + 16 * chunk cost, which are `first` more in a node of n.
  LB_INLINE __m512 costs(std::uint32_t chunk, std::uint32_t first, std::uint32_t n) const {
    const __m512i steps = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const __m512i k =
        _mm512_add_epi32(_mm512_set1_epi32(static_cast<int>(first + 1 + chunk * kAtOnce)), steps);
    const __m512i rest = _mm512_sub_epi32(_mm512_set1_epi32(static_cast<int>(n)), k);
    const __m512 right = _mm512_permutex2var_ps(
        right_[chunk], _mm512_add_epi32(steps, _mm512_set1_epi32(static_cast<int>(shift_))),
        right_[std::min(chunk + 1, chunks_ - 1)]);
    return _mm512_add_ps(_mm512_mul_ps(left_[chunk], _mm512_cvtepi32_ps(k)),
                         _mm512_mul_ps(right, _mm512_cvtepi32_ps(rest)));
  }

 private:
  static LB_INLINE __m512 pair_of(V8f left, V8f right) {
    return _mm512_insertf32x8(_mm512_castps256_ps512(reinterpret_cast<__m256>(left)),
                              reinterpret_cast<__m256>(right), 1);
  }

  /// Adds eight records to each of the two boxes; half areas after each.
  static LB_INLINE __m512 eight_steps(const Record* low, const Record* high, __m512& box) {
    __m512 extent[4];  // negated: left and right of an even step, left and right of an odd one
    for (std::uint32_t i = 0; i < 4; ++i, low += 2, high -= 2) {
      const __m512 even = _mm512_min_ps(pair_of(load_box(low), load_box(high)), box);
      box = _mm512_min_ps(pair_of(load_box(low + 1), load_box(high - 1)), even);
      extent[i] = _mm512_add_ps(_mm512_shuffle_f32x4(even, box, 0x88),
                                _mm512_shuffle_f32x4(even, box, 0xdd));
    }
    const __m512 ab_low = _mm512_unpacklo_ps(extent[0], extent[1]);
    const __m512 cd_low = _mm512_unpacklo_ps(extent[2], extent[3]);
    const __m512 ab_high = _mm512_unpackhi_ps(extent[0], extent[1]);
    const __m512 cd_high = _mm512_unpackhi_ps(extent[2], extent[3]);
    const __m512 x = _mm512_shuffle_ps(ab_low, cd_low, 0x44);
    const __m512 y = _mm512_shuffle_ps(ab_low, cd_low, 0xee);
    const __m512 z = _mm512_shuffle_ps(ab_high, cd_high, 0x44);
    return _mm512_add_ps(_mm512_add_ps(_mm512_mul_ps(x, y), _mm512_mul_ps(y, z)),
                         _mm512_mul_ps(z, x));
  }

  static constexpr std::uint32_t kMost = kLargeBlock / kAtOnce;
  std::uint32_t chunks_, shift_;
  __m512 left_[kMost], right_[kMost];
};

LB_INLINE void sweep_inside(const Record* r, std::uint32_t count, std::uint32_t first, V8f before,
                            V8f after, const SweepContext& context, Split& best) {
  const BothAreas areas(r, count, before, after);
  for (std::uint32_t chunk = 0; chunk < areas.chunks(); ++chunk) {
    const std::uint32_t j = 1 + chunk * kAtOnce;
    const __m512 cost = areas.costs(chunk, first, context.n);
    unsigned mask = _mm512_cmp_ps_mask(cost, _mm512_set1_ps(best.cost), _CMP_LE_OQ) &
                    ((1u << std::min(kAtOnce, count - j)) - 1);
    if (mask == 0) continue;
    alignas(64) float costs[kAtOnce];
    _mm512_store_ps(costs, cost);
    for (; mask != 0; mask &= mask - 1) {
      const auto i = static_cast<std::uint32_t>(std::countr_zero(mask));
      const std::uint32_t k = first + j + i;
      if (k < context.range.first || k > context.range.last) continue;
      best.offer(costs[i], context.axis, k, tie_rank(k, context.n));
    }
  }
}

/// The cheapest split of a node of at most kWholeSweep; every position is allowed.
LB_INLINE Split cheapest(const std::array<const Record*, 3>& r, std::uint32_t n, V8f& box) {
  constexpr std::uint32_t kMost = kWholeSweep / kAtOnce;
  const std::uint32_t chunks = (n - 1 + kAtOnce - 1) / kAtOnce;
  const __m512 none = _mm512_set1_ps(std::numeric_limits<float>::infinity());
  __m512 cost[3][kMost], least = none;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const BothAreas areas(r[axis], n, empty_box(), empty_box());
    for (std::uint32_t c = 0; c < chunks; ++c) {
      const std::uint32_t positions = std::min(kAtOnce, n - 1 - c * kAtOnce);
      const auto valid = static_cast<__mmask16>((1u << positions) - 1);
      cost[axis][c] = _mm512_mask_blend_ps(valid, none, areas.costs(c, 0, n));
      least = _mm512_min_ps(cost[axis][c], least);
    }
  }
  box = box_of(r[0], n);
  const float best = _mm512_reduce_min_ps(least);
  if (!(best < std::numeric_limits<float>::infinity())) return Split::middle(n);
  std::array<std::uint64_t, 3> where{};  // bit k: position k + 1
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::uint32_t c = 0; c < chunks; ++c) {
      const std::uint64_t mask =
          _mm512_cmp_ps_mask(cost[axis][c], _mm512_set1_ps(best), _CMP_EQ_OQ);
      where[axis] |= mask << (c * kAtOnce);
    }
  }
  return nearest_to_middle(where, best, n);
}
