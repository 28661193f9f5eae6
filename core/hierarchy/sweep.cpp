#include "core/hierarchy/sweep.h"

#include <cstddef>

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
  // Lists start at different places within a page: loads and stores a multiple of 4 KB apart would
  // wait for each other.
  constexpr std::size_t kStagger = 13 * 64;
  const std::size_t bytes = (boxes.size() * sizeof(Record) + 4095) / 4096 * 4096;
  LargeVector<std::byte> scratch(6 * (bytes + kStagger));
  SweepLists lists;
  lists.count = static_cast<std::uint32_t>(boxes.size());
  for (std::size_t i = 0; i < 6; ++i) {
    lists.buffer[i / 3][i % 3] = reinterpret_cast<Record*>(scratch.data() + i * (bytes + kStagger));
  }
  presort(boxes, lists.buffer[0], lists.buffer[1]);
  TreeArrays tree(boxes.size());
  (function != nullptr ? function : best_function())(lists, tree);
  return tree;
}

}  // namespace lightbatch::hierarchy
