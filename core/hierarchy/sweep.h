#pragma once

#include <span>

#include "core/hierarchy/builder.h"

namespace lightbatch::hierarchy {

/// The full sweep down to single primitives. One function for each instruction set, compiled from
/// sweep_impl.h; all write the same tree bit for bit.
using SweepFunction = void (*)(std::span<const Aabb> boxes, TreeArrays& tree);
void sweep_baseline(std::span<const Aabb> boxes, TreeArrays& tree);
/// Only on a processor that has AVX2.
void sweep_avx2(std::span<const Aabb> boxes, TreeArrays& tree);
/// Only where sweep_avx512_runs().
void sweep_avx512(std::span<const Aabb> boxes, TreeArrays& tree);
bool sweep_avx512_runs();

/// Sweep with the best instruction set (or the given function). n >= 1.
TreeArrays sweep(std::span<const Aabb> boxes, SweepFunction function = nullptr);

}  // namespace lightbatch::hierarchy
