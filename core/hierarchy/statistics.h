#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/hierarchy/hierarchy.h"
#include "core/math/vec.h"

namespace lightbatch::hierarchy {

/// Nodes at one depth; areas over the root's.
struct LevelStatistics {
  int level = 0;
  std::uint32_t inner = 0;
  std::uint32_t leaves = 0;
  double area = 0;       // sum of surface areas
  double void_area = 0;  // of inner nodes: see Statistics
};

struct Statistics {
  std::uint32_t primitives = 0;
  std::uint32_t nodes = 0;
  int depth = 0;
  double mean_leaf_depth = 0;
  /// Expected cost of a ray that meets the root, traversal 1 and intersection 1: sum over inner
  /// nodes of A / A_root + sum over leaves of A / A_root * primitives.
  double sah_cost = 0;
  /// The same after merging subtrees of at most 8 primitives wherever that lowers it, as builders
  /// with larger leaves do: the figure to compare with theirs.
  double sah_cost_merged = 0;
  /// Sum over inner nodes of max(0, A - A_left - A_right) / A_root: the chance to enter a box and
  /// meet neither child, as far as areas tell.
  double void_area = 0;
  std::vector<LevelStatistics> levels;
};

/// An empty or flat-to-a-point tree measures as zero.
Statistics measure(const Hierarchy& tree);

/// Effective partial overlap (Aila, Karras, Laine: On Quality Metrics of Bounding Volume
/// Hierarchies, HPG 2013): expected number of boxes that hold a point of the surface without
/// holding its triangle. Estimated on `samples` area-uniform surface points; same seed, same
/// figure.
double effective_partial_overlap(const Hierarchy& tree, std::span<const Vec3f> positions,
                                 std::span<const std::array<std::uint32_t, 3>> triangles,
                                 std::uint32_t samples, std::uint64_t seed);

}  // namespace lightbatch::hierarchy
