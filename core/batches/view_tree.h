#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/batches/cut.h"
#include "core/batches/views.h"

namespace lightbatch::batches {

/// A binary tree over clusters, split for what views see of them. Depth-first order; node i covers
/// order[first[i]] to order[first[i] + count[i] - 1].
struct ViewTree {
  CutTree tree;
  std::vector<Aabb> box;  // tight
  std::vector<std::uint32_t> first, count;
  std::vector<std::uint32_t> order;  // of the clusters, by leaf
  std::span<const std::uint32_t> clusters(std::uint32_t i) const {
    return std::span(order).subspan(first[i], count[i]);
  }
};

/// Splits from the root down to single clusters, each time where the most triangles are expected
/// to be saved for each draw added. boxes, triangles: of each cluster.
ViewTree split_by_views(std::span<const Aabb> boxes, std::span<const double> triangles,
                        const ViewDistribution& views);

}  // namespace lightbatch::batches
