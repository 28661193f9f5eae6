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
#else
LB_INLINE unsigned mask8(V8i v) {
  unsigned mask = 0;
  for (unsigned i = 0; i < 8; ++i) mask |= v[i] < 0 ? 1u << i : 0u;
  return mask;
}
LB_INLINE V8f madd8(V8f a, V8f b, V8f c) { return a * b + c; }
#endif
LB_INLINE std::size_t lowest(unsigned mask) {
  return static_cast<std::size_t>(std::countr_zero(mask));
}
