#pragma once

#include <cstdint>
#include <vector>

#include "core/batches/assignment.h"
#include "core/batches/cut.h"
#include "core/hierarchy/hierarchy.h"

namespace lightbatch::batches {

/// The hierarchy over the triangles that may be merged, down to small nodes; nodes with nothing to
/// merge on one side are passed over. What dynamic programming runs on.
struct CoarseTree {
  CutTree tree;
  std::vector<hierarchy::Hierarchy::NodeId> node;  // of the hierarchy
  std::vector<ShareCost> cost;                     // of the node as one batch
  std::uint32_t size() const { return tree.size(); }
};

CoarseTree make_coarse_tree(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
                            const std::vector<bool>& merged_triangle, const KeyMap& keys,
                            const Profile& profile, std::uint32_t max_vertices,
                            const ViewDistribution& views);

}  // namespace lightbatch::batches
