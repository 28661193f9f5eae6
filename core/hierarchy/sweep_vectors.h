// Vector pieces of the sweep; included by sweep_costs.h only.

using V8f = float __attribute__((vector_size(32)));
using V8i = std::int32_t __attribute__((vector_size(32)));
using V4f = float __attribute__((vector_size(16)));
using V4i = std::int32_t __attribute__((vector_size(16)));

#define LB_INLINE inline __attribute__((always_inline))
#define LB_LAMBDA_INLINE __attribute__((always_inline))

LB_INLINE V8f load_box(const void* p) {
  V8f v;
  std::memcpy(&v, __builtin_assume_aligned(p, 32), sizeof v);
  return v;
}
LB_INLINE void store_box(void* p, V8f v) {
  std::memcpy(__builtin_assume_aligned(p, 32), &v, sizeof v);
}
/// Lower planes and negated upper planes: the minimum is the union.
LB_INLINE V8f unite(V8f a, V8f b) { return a < b ? a : b; }
LB_INLINE V8f empty_box() {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  return V8f{kInf, kInf, kInf, kInf, kInf, kInf, kInf, kInf};
}
/// Minus the extents, exactly; products of two of them have the right sign.
LB_INLINE V4f negated_extent(V8f box) {
  return __builtin_shufflevector(box, box, 0, 1, 2, 3) +
         __builtin_shufflevector(box, box, 4, 5, 6, 7);
}
LB_INLINE float area_of(V8f box) {
  const V4f e = negated_extent(box);
  return half_area(e[0], e[1], e[2]);
}
/// Half areas of four boxes, as half_area computes them.
LB_INLINE V4f areas_of(V4f a, V4f b, V4f c, V4f d) {
  const V4f ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5);  // ax bx ay by
  const V4f cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5);
  const V4f ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);  // az bz
  const V4f cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
  const V4f x = __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5);
  const V4f y = __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7);
  const V4f z = __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5);
  return x * y + y * z + z * x;
}
#if defined(__SSE2__)
LB_INLINE unsigned mask4(V4i v) {
  return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(v)));
}
#else
LB_INLINE unsigned mask4(V4i v) {
  unsigned mask = 0;
  for (unsigned i = 0; i < 4; ++i) mask |= v[i] < 0 ? 1u << i : 0u;
  return mask;
}
#endif
LB_INLINE V4f infinite4() {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  return V4f{kInf, kInf, kInf, kInf};
}
LB_INLINE float least_of(V4f v) {
  const float a = v[0] < v[1] ? v[0] : v[1], b = v[2] < v[3] ? v[2] : v[3];
  return a < b ? a : b;
}
