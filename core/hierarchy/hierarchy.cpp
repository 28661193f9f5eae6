#include "core/hierarchy/hierarchy.h"

#include <utility>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/hierarchy/builder.h"
#include "core/hierarchy/reinsertion.h"
#include "core/hierarchy/sweep.h"

namespace lightbatch::hierarchy {

Hierarchy HierarchyBuilder::finish(TreeArrays&& arrays) {
  Hierarchy tree;
  tree.nodes_ = std::move(arrays.nodes);
  tree.primitives_ = std::move(arrays.primitives);
  return tree;
}

void Hierarchy::compact() {
  if (is_compact()) return;
  compact_ = CompactNodes(nodes_);
  nodes_ = TreeNodes();
}

std::size_t Hierarchy::memory_bytes() const {
  return nodes_.capacity() * sizeof(TreeNode) + compact_.memory_bytes() +
         primitives_.capacity() * sizeof(std::uint32_t);
}

Hierarchy build(std::span<const Aabb> boxes, const BuildOptions& options) {
  LB_CHECK(boxes.size() <= (std::size_t{1} << 30), "more primitives than the hierarchy can hold");
  if (boxes.empty()) return {};
  parallel_for(boxes.size(), 1u << 16, [&](std::size_t begin, std::size_t end) {
    for (const Aabb& box : boxes.subspan(begin, end - begin)) {
      LB_CHECK(is_finite(box.lower) && is_finite(box.upper) && !box.is_empty() &&
                   box.lower.y <= box.upper.y && box.lower.z <= box.upper.z,
               "hierarchy boxes must be finite with lower <= upper");
    }
  });
  TreeArrays tree = sweep(boxes);
  if (options.reinsertion) reinsert(tree);
  return HierarchyBuilder::finish(std::move(tree));
}

}  // namespace lightbatch::hierarchy
