#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/hierarchy/builder.h"
#include "core/hierarchy/records.h"

namespace lightbatch::hierarchy {

/// The three sorted lists, twice: every node keeps, for each axis, which of the two its part is in.
struct SweepLists {
  std::array<std::array<Record*, 3>, 2> buffer;
  std::uint32_t count = 0;
};

/// Splits the sorted lists (in buffer 0) down to single primitives. One function for each
/// instruction set, compiled from sweep_impl.h; all write the same tree bit for bit.
using SweepFunction = void (*)(const SweepLists& lists, TreeArrays& tree);
void sweep_baseline(const SweepLists& lists, TreeArrays& tree);
/// Only on a processor that has AVX2.
void sweep_avx2(const SweepLists& lists, TreeArrays& tree);

/// Presort and sweep with the best instruction set (or the given function). n >= 1.
TreeArrays sweep(std::span<const Aabb> boxes, SweepFunction function = nullptr);

}  // namespace lightbatch::hierarchy
