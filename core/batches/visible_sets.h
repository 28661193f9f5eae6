#pragma once

#include <cstdint>
#include <vector>

#include "core/base/progress.h"
#include "core/base/status.h"
#include "core/batches/plan.h"

namespace lightbatch::batches {

/// What can be seen from somewhere in a box where people's eyes can be.
struct ViewCell {
  Aabb box;                         // of eyes; recentred coordinates
  std::vector<std::uint32_t> seen;  // batches, then instance cells after them; ascending
};

/// Potentially visible sets (Airey, Rohlf, Brooks 1990), by sampling: what no sample found is left
/// out, so a set may lack a sliver seen through a crack. `missed` says how rarely: of `checked`
/// rays that had no part in finding the sets, from anywhere in a cell in any direction, so many met
/// something that the cell's set lacks.
struct VisibleSets {
  std::vector<ViewCell> cells;
  std::uint64_t rays = 0;
  std::uint64_t checked = 0, missed = 0;
  double mean_share = 0;  // of batches and instance cells that a view cell sees
};

struct VisibleSetOptions {
  std::uint64_t seed = 1;
  std::uint32_t most_cells = 1024;
  /// A cell is done when so many rays in a row found nothing new: what is left is then met by less
  /// than one ray in a third of that number (95 %).
  std::uint32_t barren_rays = 8192;
  std::uint32_t most_rays = 262144;  // of a cell
  std::vector<bool> opens;           // objects that may come to hide nothing; or empty
};

/// The sets of cells over walkable space: a grid of about an eye's height, coarser where that would
/// make more than most_cells. Single-sided triangles hide nothing from behind, and blended, cut-out
/// and transmitting ones nothing at all; nor does what `opens`, or what the plan left alone for
/// other reasons than its looks or size: it may move or be hidden. What moves or was left alone is
/// in no set. CANCELLED.
Result<VisibleSets> find_visible_sets(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
                                      const Viewpoints& viewpoints, const BatchPlan& plan,
                                      const VisibleSetOptions& options,
                                      const Progress& progress = {});

}  // namespace lightbatch::batches
