#include "core/rays/kernel.h"

#if defined(__x86_64__)
#include <immintrin.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "core/hierarchy/split_rule.h"
#include "core/rays/exact_test.h"

#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2,popcnt,fma,bmi"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,popcnt,fma,bmi")
#endif
#define LB_KERNEL_AVX2

namespace lightbatch::rays {
namespace {

#include "core/rays/kernel_impl.h"

}  // namespace

const Kernel& avx2_kernel() {
  static constexpr Kernel kKernel = {cast_closest, cast_occluded, cast_bundles};
  return kKernel;
}

}  // namespace lightbatch::rays

#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
