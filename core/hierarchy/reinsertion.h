#pragma once

#include "core/hierarchy/builder.h"

namespace lightbatch::hierarchy {

/// Lowers the cost of a finished tree (Statistics::sah_cost_merged) by moving subtrees to better
/// places. Primitives stay single; the result is laid out depth-first again and is the same on any
/// number of threads. A result that costs no less or is deeper than kMaxDepth is thrown away: then
/// the tree stays as it was.
void reinsert(TreeArrays& tree);

}  // namespace lightbatch::hierarchy
