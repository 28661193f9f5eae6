#include "core/hierarchy/hierarchy.h"

#include <limits>
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
  parallel_for(boxes.size(), 1u << 14, [&](std::size_t begin, std::size_t end) {
    bool ordered = true;  // and finite; without a branch for each box
    for (const Aabb& box : boxes.subspan(begin, end - begin)) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float low = box.lower[axis], high = box.upper[axis];
        ordered &= (low >= -std::numeric_limits<float>::max()) & (low <= high) &
                   (high <= std::numeric_limits<float>::max());
      }
    }
    LB_CHECK(ordered, "hierarchy boxes must be finite with lower <= upper");
  });
  TreeArrays tree = sweep(boxes);
  if (options.reinsertion) reinsert(tree);
  return HierarchyBuilder::finish(std::move(tree));
}

}  // namespace lightbatch::hierarchy
