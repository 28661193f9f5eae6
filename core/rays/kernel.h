#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/rays/caster.h"
#include "core/rays/shaft.h"
#include "core/rays/wide_tree.h"

namespace lightbatch::rays {

/// The casting loops, compiled once for each instruction set from kernel_impl.h. All give the same
/// answers bit for bit: ExactTest decides.
struct Kernel {
  Hit (*closest)(const WideTree&, const Ray&, std::uint32_t exclude, HitFilter*);
  bool (*occluded)(const WideTree&, const Ray&, std::uint32_t exclude_a, std::uint32_t exclude_b,
                   HitFilter*);
  /// Like occluded, over the given nodes only.
  bool (*occluded_from)(const WideTree&, std::span<const WideNode> start, const Ray&,
                        std::uint32_t exclude_a, std::uint32_t exclude_b, HitFilter*);
  /// Packs the subtrees that may reach into the shaft into at most Shaft::kMost / 8 nodes.
  std::size_t (*gather)(const WideTree&, const Shaft&, WideNode* packs);
};

const Kernel& baseline_kernel();
/// Only to be called on a processor that has AVX2 and FMA.
const Kernel& avx2_kernel();
/// The best for this processor.
const Kernel& kernel();

}  // namespace lightbatch::rays
