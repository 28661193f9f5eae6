#pragma once

#include "core/hierarchy/builder.h"

namespace lightbatch::hierarchy {

/// Lowers the sum of box areas of a finished tree by moving subtrees to better places. Primitives
/// stay single; the result is laid out depth-first again and is the same on any number of threads.
/// A result deeper than kMaxDepth is thrown away: then the tree stays as it was.
void reinsert(TreeArrays& tree);

}  // namespace lightbatch::hierarchy
