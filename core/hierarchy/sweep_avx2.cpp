#include "core/hierarchy/sweep.h"

#if defined(__x86_64__)
#include <immintrin.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "core/base/parallel.h"
#include "core/hierarchy/records.h"
#include "core/hierarchy/split_rule.h"

#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2,bmi,bmi2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,bmi,bmi2")
#endif

#define LB_SWEEP_SMALL

namespace lightbatch::hierarchy {
namespace {

#include "core/hierarchy/sweep_impl.h"
}  // namespace

void sweep_avx2(std::span<const Aabb> boxes, TreeArrays& tree) { Sweep(boxes, tree).run(); }

}  // namespace lightbatch::hierarchy

#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
