// Sixteen lanes, one a ray; included by kernel_impl.h only. Masks hold a bit a lane.

constexpr std::size_t kLanes = 16;

/// Whether testing sixteen lanes costs less than finding out that it is not needed, in trees that
/// fit the caches.
#ifdef LB_KERNEL_AVX512
constexpr bool kAllBoxes = true;
#else
constexpr bool kAllBoxes = false;
#endif

#ifdef LB_KERNEL_AVX512
struct Wide {
  __m512 v;
};
LB_INLINE Wide load16(const float* p) { return {_mm512_loadu_ps(p)}; }
LB_INLINE void store16(float* p, Wide a) { _mm512_storeu_ps(p, a.v); }
LB_INLINE Wide splat16(float x) { return {_mm512_set1_ps(x)}; }
LB_INLINE Wide operator+(Wide a, Wide b) { return {_mm512_add_ps(a.v, b.v)}; }
LB_INLINE Wide operator-(Wide a, Wide b) { return {_mm512_sub_ps(a.v, b.v)}; }
LB_INLINE Wide operator*(Wide a, Wide b) { return {_mm512_mul_ps(a.v, b.v)}; }
LB_INLINE Wide operator/(Wide a, Wide b) { return {_mm512_div_ps(a.v, b.v)}; }
LB_INLINE Wide madd16(Wide a, Wide b, Wide c) { return {_mm512_fmadd_ps(a.v, b.v, c.v)}; }
LB_INLINE Wide max16(Wide a, Wide b) { return {_mm512_max_ps(a.v, b.v)}; }
LB_INLINE Wide min16(Wide a, Wide b) { return {_mm512_min_ps(a.v, b.v)}; }
LB_INLINE Wide abs16(Wide a) { return {_mm512_abs_ps(a.v)}; }
LB_INLINE unsigned less16(Wide a, Wide b) { return _mm512_cmp_ps_mask(a.v, b.v, _CMP_LT_OQ); }
LB_INLINE unsigned at_most16(Wide a, Wide b) { return _mm512_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ); }
LB_INLINE unsigned equal16(const std::uint32_t* p, std::uint32_t x) {
  return _mm512_cmpeq_epi32_mask(_mm512_loadu_si512(p), _mm512_set1_epi32(static_cast<int>(x)));
}
/// a where the mask is set, else b.
LB_INLINE Wide select16(unsigned mask, Wide a, Wide b) {
  return {_mm512_mask_blend_ps(static_cast<__mmask16>(mask), b.v, a.v)};
}
LB_INLINE V8f half16(Wide a, bool upper) {
  return upper ? _mm512_extractf32x8_ps(a.v, 1) : _mm512_castps512_ps256(a.v);
}
LB_INLINE Wide join16(V8f low, V8f high) {
  return {_mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1)};
}
#else
struct Wide {
  V8f low, high;
};
LB_INLINE Wide join16(V8f low, V8f high) { return {low, high}; }
LB_INLINE Wide load16(const float* p) { return {load8(p), load8(p + 8)}; }
LB_INLINE void store16(float* p, Wide a) { std::memcpy(p, &a, sizeof a); }
LB_INLINE Wide splat16(float x) { return {splat8(x), splat8(x)}; }
LB_INLINE Wide operator+(Wide a, Wide b) { return {a.low + b.low, a.high + b.high}; }
LB_INLINE Wide operator-(Wide a, Wide b) { return {a.low - b.low, a.high - b.high}; }
LB_INLINE Wide operator*(Wide a, Wide b) { return {a.low * b.low, a.high * b.high}; }
LB_INLINE Wide operator/(Wide a, Wide b) { return {a.low / b.low, a.high / b.high}; }
LB_INLINE Wide madd16(Wide a, Wide b, Wide c) {
  return {madd8(a.low, b.low, c.low), madd8(a.high, b.high, c.high)};
}
LB_INLINE Wide max16(Wide a, Wide b) { return {max8(a.low, b.low), max8(a.high, b.high)}; }
LB_INLINE Wide min16(Wide a, Wide b) { return {min8(a.low, b.low), min8(a.high, b.high)}; }
LB_INLINE Wide abs16(Wide a) { return {abs8(a.low), abs8(a.high)}; }
LB_INLINE unsigned less16(Wide a, Wide b) {
  return mask8(a.low < b.low) | mask8(a.high < b.high) << 8;
}
LB_INLINE unsigned at_most16(Wide a, Wide b) {
  return mask8(a.low <= b.low) | mask8(a.high <= b.high) << 8;
}
LB_INLINE unsigned equal16(const std::uint32_t* p, std::uint32_t x) {
  unsigned mask = 0;
  for (unsigned i = 0; i < kLanes; ++i) mask |= p[i] == x ? 1u << i : 0u;
  return mask;
}
LB_INLINE V8f select8(unsigned mask, V8f a, V8f b) {
  const V8i bits{1, 2, 4, 8, 16, 32, 64, 128};
  return (bits & static_cast<std::int32_t>(mask)) != 0 ? a : b;
}
LB_INLINE Wide select16(unsigned mask, Wide a, Wide b) {
  return {select8(mask & 255u, a.low, b.low), select8(mask >> 8, a.high, b.high)};
}
LB_INLINE V8f half16(Wide a, bool upper) { return upper ? a.high : a.low; }
#endif

/// Sixteen bits each of eight words, the first four in `low`.
LB_INLINE V8i spread8(std::uint64_t low, std::uint64_t high) {
  using Halves = std::uint64_t __attribute__((vector_size(16)));
  using Shorts = std::uint16_t __attribute__((vector_size(16)));
  return __builtin_convertvector(reinterpret_cast<Shorts>(Halves{low, high}), V8i);
}

#ifndef LB_KERNEL_AVX512
/// The places of the bits of a byte, in order, for every byte.
constexpr auto kPlacesOfBits = [] {
  std::array<std::array<std::uint8_t, 8>, 256> places{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    std::size_t count = 0;
    for (std::uint8_t bit = 0; bit < 8; ++bit) {
      if ((byte >> bit & 1u) != 0) places[byte][count++] = bit;
    }
  }
  return places;
}();
#endif

/// Puts the marked words of `from` in order to `to`, where there is room for eight; how many.
LB_INLINE std::size_t pack8(unsigned marked, const std::uint32_t* from, std::uint32_t* to) {
#ifdef LB_KERNEL_AVX512
  const __m256i words = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
                      _mm256_maskz_compress_epi32(static_cast<__mmask8>(marked), words));
#else
  using Bytes = std::uint8_t __attribute__((vector_size(8)));
  Bytes places;
  std::memcpy(&places, kPlacesOfBits[marked].data(), sizeof places);
  permute8(to, from, __builtin_convertvector(places, V8i));
#endif
  return static_cast<std::size_t>(std::popcount(marked));
}

/// The least lane of each of four vectors.
LB_INLINE V4f least_of_four(Wide a, Wide b, Wide c, Wide d) {
  const auto to_four = [](Wide w) LB_LAMBDA_INLINE {
    const V8f v = min8(half16(w, false), half16(w, true));
    const V4f p = __builtin_shufflevector(v, v, 0, 1, 2, 3);
    const V4f q = __builtin_shufflevector(v, v, 4, 5, 6, 7);
    return p < q ? p : q;
  };
  const V4f p = to_four(a), q = to_four(b), r = to_four(c), s = to_four(d);
  const V4f pq_low = __builtin_shufflevector(p, q, 0, 4, 1, 5);
  const V4f pq_high = __builtin_shufflevector(p, q, 2, 6, 3, 7);
  const V4f rs_low = __builtin_shufflevector(r, s, 0, 4, 1, 5);
  const V4f rs_high = __builtin_shufflevector(r, s, 2, 6, 3, 7);
  const V4f pq = pq_low < pq_high ? pq_low : pq_high;  // p0 q0 p1 q1
  const V4f rs = rs_low < rs_high ? rs_low : rs_high;
  const V4f even = __builtin_shufflevector(pq, rs, 0, 1, 4, 5);
  const V4f odd = __builtin_shufflevector(pq, rs, 2, 3, 6, 7);
  return even < odd ? even : odd;
}
