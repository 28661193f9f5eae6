#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/rays/caster.h"
#include "core/rays/wide_tree.h"

namespace lightbatch::rays {

/// The casting loops, compiled once for each instruction set from kernel_impl.h. All give the same
/// answers bit for bit: ExactTest decides.
struct Kernel {
  Hit (*closest)(const WideTree&, const Ray&, std::uint32_t exclude, HitFilter*);
  bool (*occluded)(const WideTree&, const Ray&, std::uint32_t exclude_a, std::uint32_t exclude_b,
                   HitFilter*);
  /// Bit j of the i-th: something stops segment 16 i + j.
  void (*bundles)(const WideTree&, std::span<const Segment>, std::span<std::uint32_t>);
};

const Kernel& baseline_kernel();
/// Only to be called on a processor that has AVX2 and FMA.
const Kernel& avx2_kernel();
/// Only to be called on a processor that has AVX-512 F, VL, DQ and BW besides.
const Kernel& avx512_kernel();
bool has_avx2();
bool has_avx512();
/// The best for this processor.
const Kernel& kernel();

}  // namespace lightbatch::rays
