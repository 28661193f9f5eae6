#include "core/hierarchy/sweep.h"

namespace lightbatch::hierarchy {
namespace {

SweepFunction best_function() {
#if defined(__x86_64__)
  static const bool has_avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
                               __builtin_cpu_supports("bmi2");
  if (has_avx2) return sweep_avx2;
#endif
  return sweep_baseline;
}

}  // namespace

TreeArrays sweep(std::span<const Aabb> boxes, SweepFunction function) {
  TreeArrays tree(boxes.size());
  (function != nullptr ? function : best_function())(boxes, tree);
  return tree;
}

}  // namespace lightbatch::hierarchy
