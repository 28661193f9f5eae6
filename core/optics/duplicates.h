#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/scene/scene.h"

namespace lightbatch::optics {

/// Of the given triangles, those with the very corners of another of them of lower index, facing
/// the same way: of two at one place rays meet the lower index, so the other one is never seen.
/// O(n log n). Ascending.
std::vector<std::uint32_t> hidden_duplicates(const scene::Scene& scene,
                                             std::span<const std::uint32_t> triangles);

}  // namespace lightbatch::optics
