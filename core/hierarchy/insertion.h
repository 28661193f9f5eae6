#pragma once

#include <optional>
#include <span>

#include "core/hierarchy/builder.h"

namespace lightbatch::hierarchy {

/// J. Goldsmith, J. Salmon: Automatic Creation of Object Hierarchies for Ray Tracing, 1987: each
/// primitive goes down the tree to the child whose area grows less, and stops where pairing it with
/// the whole node costs less than going on. Order: shuffled, always the same way. Nothing when the
/// tree becomes deeper than kMaxDepth. n >= 1.
std::optional<TreeArrays> build_by_insertion(std::span<const Aabb> boxes);

}  // namespace lightbatch::hierarchy
