#include "core/hierarchy/sweep.h"

namespace lightbatch::hierarchy {
namespace {

SweepFunction best_function() {
#if defined(__x86_64__)
  static const bool has_avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
                               __builtin_cpu_supports("bmi2");
  if (sweep_avx512_runs()) return sweep_avx512;
  if (has_avx2) return sweep_avx2;
#endif
  return sweep_baseline;
}

}  // namespace

bool sweep_avx512_runs() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("bmi2");
#else
  return false;
#endif
}

TreeArrays sweep(std::span<const Aabb> boxes, SweepFunction function) {
  TreeArrays tree(boxes.size());
  (function != nullptr ? function : best_function())(boxes, tree);
  return tree;
}

}  // namespace lightbatch::hierarchy
