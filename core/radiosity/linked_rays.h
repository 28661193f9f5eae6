#pragma once

#include <cstdint>
#include <vector>

#include "core/base/progress.h"
#include "core/radiosity/linked_tree.h"

namespace lightbatch::radiosity {

/// Cosine rays of every element of the linked mode: what share of its hemisphere meets elements at
/// all (the row sum that its links must have), what comes from its near field, and the sky.
struct CosineRays {
  std::vector<std::uint64_t> start;  // per element, into the rest; one past
  std::vector<std::uint32_t> place;  // what was hit, in leaf order; ascending within an element
  std::vector<Rgb> weight;           // of sheets before it; empty: all 1
  std::vector<std::uint8_t> near;    // the hit lies in the element's near field
  std::vector<float> scale;          // 1 / rays
  std::vector<Rgb> sky;              // irradiance from rays that left the scene, lux

  Rgb weight_of(std::uint64_t k) const { return weight.empty() ? Rgb{1, 1, 1} : weight[k]; }
  /// Share of the element's hemisphere that meets elements, mean over channels.
  float met(ElementId e, bool near_only) const;
  std::size_t memory_bytes() const;
};

CosineRays shoot_cosine_rays(const SolverInput& input, const LinkTree& tree,
                             const SolverOptions& options, RayCounts& counts,
                             const Progress& progress);

}  // namespace lightbatch::radiosity
