// Vector pieces of the casting loops; included by kernel_impl.h only.

using V8f = float __attribute__((vector_size(32)));
using V8i = std::int32_t __attribute__((vector_size(32)));
using V4f = float __attribute__((vector_size(16)));
using V4i = std::int32_t __attribute__((vector_size(16)));

#define LB_INLINE inline __attribute__((always_inline))
#define LB_LAMBDA_INLINE __attribute__((always_inline))

LB_INLINE V8f load8(const float* p) {
  V8f v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
LB_INLINE V4f load4(const float* p) {
  V4f v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
LB_INLINE V8f splat8(float x) { return V8f{x, x, x, x, x, x, x, x}; }
LB_INLINE V4f splat4(float x) { return V4f{x, x, x, x}; }
/// The second argument where either is NaN.
LB_INLINE V8f max8(V8f a, V8f b) { return a > b ? a : b; }
LB_INLINE V8f min8(V8f a, V8f b) { return a < b ? a : b; }
LB_INLINE V8f abs8(V8f a) {
  V8i bits;
  std::memcpy(&bits, &a, sizeof bits);
  bits &= 0x7fffffff;
  std::memcpy(&a, &bits, sizeof a);
  return a;
}
LB_INLINE V4f abs4(V4f a) {
  V4i bits;
  std::memcpy(&bits, &a, sizeof bits);
  bits &= 0x7fffffff;
  std::memcpy(&a, &bits, sizeof a);
  return a;
}
#ifdef LB_KERNEL_AVX2
LB_INLINE unsigned mask8(V8i v) {
  return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(v)));
}
LB_INLINE V8f madd8(V8f a, V8f b, V8f c) { return _mm256_fmadd_ps(a, b, c); }
/// to[i] = from[places[i]], places in 0..7.
LB_INLINE void permute8(std::uint32_t* to, const std::uint32_t* from, V8i places) {
  const __m256i words = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
                      _mm256_permutevar8x32_epi32(words, reinterpret_cast<__m256i>(places)));
}
#else
LB_INLINE unsigned mask8(V8i v) {
  unsigned mask = 0;
  for (unsigned i = 0; i < 8; ++i) mask |= v[i] < 0 ? 1u << i : 0u;
  return mask;
}
LB_INLINE V8f madd8(V8f a, V8f b, V8f c) { return a * b + c; }
LB_INLINE void permute8(std::uint32_t* to, const std::uint32_t* from, V8i places) {
  for (unsigned i = 0; i < 8; ++i) to[i] = from[places[i]];
}
#endif
LB_INLINE void store4(float* p, V4f v) { std::memcpy(p, &v, sizeof v); }
LB_INLINE V4f max4(V4f a, V4f b) { return a > b ? a : b; }
/// Component j of row i becomes component i of row j.
LB_INLINE void transpose4(V4f* rows) {
  const V4f low01 = __builtin_shufflevector(rows[0], rows[1], 0, 4, 1, 5);
  const V4f low23 = __builtin_shufflevector(rows[2], rows[3], 0, 4, 1, 5);
  const V4f high01 = __builtin_shufflevector(rows[0], rows[1], 2, 6, 3, 7);
  const V4f high23 = __builtin_shufflevector(rows[2], rows[3], 2, 6, 3, 7);
  rows[0] = __builtin_shufflevector(low01, low23, 0, 1, 4, 5);
  rows[1] = __builtin_shufflevector(low01, low23, 2, 3, 6, 7);
  rows[2] = __builtin_shufflevector(high01, high23, 0, 1, 4, 5);
  rows[3] = __builtin_shufflevector(high01, high23, 2, 3, 6, 7);
}
LB_INLINE void store8(float* p, V8f v) { std::memcpy(p, &v, sizeof v); }
/// Component j of row i becomes component i of row j.
LB_INLINE void transpose8(V8f* rows) {
  V8f pairs[8], fours[8];
  for (std::size_t i = 0; i < 8; i += 2) {
    pairs[i] = __builtin_shufflevector(rows[i], rows[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
    pairs[i + 1] = __builtin_shufflevector(rows[i], rows[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
  }
  for (std::size_t i = 0; i < 8; i += 4) {
    for (std::size_t k = 0; k < 2; ++k) {
      const V8f a = pairs[i + k], b = pairs[i + k + 2];
      fours[i + 2 * k] = __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
      fours[i + 2 * k + 1] = __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    rows[i] = __builtin_shufflevector(fours[i], fours[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    rows[i + 4] = __builtin_shufflevector(fours[i], fours[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}
/// Descending. K. Batcher, Sorting Networks and Their Applications, AFIPS 1968.
LB_INLINE V8i sorted_down(V8i v) {
  V8i other = __builtin_shufflevector(v, v, 1, 0, 3, 2, 5, 4, 7, 6);
  V8i larger = v > other ? v : other, smaller = v > other ? other : v;
  v = __builtin_shufflevector(larger, smaller, 0, 9, 2, 11, 4, 13, 6, 15);
  other = __builtin_shufflevector(v, v, 3, 2, 1, 0, 7, 6, 5, 4);
  larger = v > other ? v : other, smaller = v > other ? other : v;
  v = __builtin_shufflevector(larger, smaller, 0, 1, 10, 11, 4, 5, 14, 15);
  other = __builtin_shufflevector(v, v, 1, 0, 3, 2, 5, 4, 7, 6);
  larger = v > other ? v : other, smaller = v > other ? other : v;
  v = __builtin_shufflevector(larger, smaller, 0, 9, 2, 11, 4, 13, 6, 15);
  other = __builtin_shufflevector(v, v, 7, 6, 5, 4, 3, 2, 1, 0);
  larger = v > other ? v : other, smaller = v > other ? other : v;
  v = __builtin_shufflevector(larger, smaller, 0, 1, 2, 3, 12, 13, 14, 15);
  other = __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5);
  larger = v > other ? v : other, smaller = v > other ? other : v;
  v = __builtin_shufflevector(larger, smaller, 0, 1, 10, 11, 4, 5, 14, 15);
  other = __builtin_shufflevector(v, v, 1, 0, 3, 2, 5, 4, 7, 6);
  larger = v > other ? v : other, smaller = v > other ? other : v;
  return __builtin_shufflevector(larger, smaller, 0, 9, 2, 11, 4, 13, 6, 15);
}
LB_INLINE std::size_t lowest(unsigned mask) {
  return static_cast<std::size_t>(std::countr_zero(mask));
}
