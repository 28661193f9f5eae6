#include "core/probes/grid.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace lightbatch::probes {
namespace {

using hierarchy::Hierarchy;

/// A way is grown by this share of its diagonal: boxes of animations are sampled, and flat ones
/// need a height.
constexpr double kMargin = 0.05;
/// The largest cubes: twice the size of what moves, within these shares of the way's longest edge.
constexpr double kLargestShare = 1.0 / 2;
constexpr double kSmallestShare = 1.0 / 16;
/// The smallest cubes against the size of what moves, and the most halvings to get there.
constexpr double kFinest = 1.0 / 4;
constexpr int kMostLevels = 3;

/// What is given up, in this order, until the probes are few enough.
struct Coarseness {
  int levels = kMostLevels;
  double scale = 1;  // of the largest cubes
  double merge = 2;  // volumes are joined when that grows their box by at most this factor
  void increase() {
    if (levels > 0) {
      --levels;
    } else if (scale < 1 / kSmallestShare) {
      scale *= 1.25;
    } else {
      merge *= 4;
    }
  }
};

bool overlaps_any(const Hierarchy& tree, const Aabb& box) {
  if (tree.is_empty()) return false;
  std::vector<Hierarchy::NodeId> pending{0};
  while (!pending.empty()) {
    const Hierarchy::NodeId node = pending.back();
    pending.pop_back();
    if (!tree.box(node).overlaps(box)) continue;
    if (tree.is_leaf(node)) return true;
    pending.push_back(tree.right(node));
    pending.push_back(tree.left(node));
  }
  return false;
}

/// Product of the box's edges, each at least a thousandth of the longest.
double bulk(const Aabb& box) {
  const Vec3d e = to_double(box.extent());
  const double least = 1e-3 * std::max({e.x, e.y, e.z});
  return std::max(e.x, least) * std::max(e.y, least) * std::max(e.z, least);
}

class Placing {
 public:
  Placing(const scene::Scene& scene, const Hierarchy& tree, const GridOptions& options)
      : scene_(scene), tree_(tree), options_(options) {
    std::vector<Aabb> ways;
    for (const scene::MovingMesh& moving : scene.moving) {
      const double margin = kMargin * moving.swept.diagonal();
      const Vec3d grow{margin, margin, margin};
      Aabb way;
      way.add(to_float(moving.swept.lower - scene.origin - grow));
      way.add(to_float(moving.swept.upper - scene.origin + grow));
      ways.push_back(way);
    }
    ways_ = hierarchy::build(ways);
  }

  ProbeGrid run() {
    Coarseness coarseness;
    while (!place(coarseness)) coarseness.increase();
    return std::move(grid_);
  }

 private:
  using Lattice = std::array<std::uint32_t, 3>;

  /// False when there are too many probes.
  bool place(const Coarseness& coarseness) {
    grid_ = {};
    std::vector<Hierarchy::NodeId> cut;
    cut_below(0, coarseness.merge, cut);
    for (const Hierarchy::NodeId node : cut) {
      add_volume(node, coarseness);
      if (grid_.positions.size() > options_.most_probes && !last_resort(coarseness)) return false;
    }
    return true;
  }

  /// One volume of one cube: there is nothing left to give up.
  bool last_resort(const Coarseness& coarseness) const {
    return coarseness.levels == 0 && coarseness.scale >= 1 / kSmallestShare &&
           coarseness.merge > 1e30;
  }

  /// Appends the volumes of a node; returns the sum of their bulks.
  double cut_below(Hierarchy::NodeId node, double merge,
                   std::vector<Hierarchy::NodeId>& cut) const {
    const double own = bulk(ways_.box(node));
    const std::size_t before = cut.size();
    if (!ways_.is_leaf(node)) {
      const double left = cut_below(ways_.left(node), merge, cut);
      const double parts = left + cut_below(ways_.right(node), merge, cut);
      if (!(own <= merge * parts)) return parts;
    }
    cut.resize(before);
    cut.push_back(node);
    return own;
  }

  void add_volume(Hierarchy::NodeId node, const Coarseness& coarseness) {
    Volume volume;
    double size = 0;
    std::set<std::uint32_t> nodes;
    for (const std::uint32_t i : ways_.primitives(node)) {
      const Vec3d e = scene_.moving[i].rest.extent();
      size += std::max({e.x, e.y, e.z}) / ways_.count(node);
      nodes.insert(scene_.moving[i].node);
    }
    volume.nodes.assign(nodes.begin(), nodes.end());
    const Aabb box = ways_.box(node);
    const Vec3d extent = to_double(box.extent());
    const double longest = std::max({extent.x, extent.y, extent.z});
    const double edge =
        std::min(1.0,
                 coarseness.scale * std::clamp(2 * size / longest, kSmallestShare, kLargestShare)) *
        longest;
    int levels = 0;
    while (levels < coarseness.levels && edge * std::exp2(-levels - 1) >= kFinest * size) ++levels;
    volume.largest = 1u << levels;
    volume.step = longest > 0 ? edge / volume.largest : 1;
    lower_ = to_double(box.lower);
    volume.origin = scene_.origin + lower_;
    Lattice count{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      count[axis] = static_cast<std::uint32_t>(
          std::max(1.0, std::ceil(extent[axis] / (volume.step * volume.largest) - 1e-6)));
      volume.extent[axis] = count[axis] * volume.largest;
    }
    for (std::uint32_t z = 0; z < count[2]; ++z) {
      for (std::uint32_t y = 0; y < count[1]; ++y) {
        for (std::uint32_t x = 0; x < count[0]; ++x) {
          add_cells(
              volume,
              {{x * volume.largest, y * volume.largest, z * volume.largest}, volume.largest, {}});
        }
      }
    }
    add_corners(volume);
    grid_.volumes.push_back(std::move(volume));
  }

  Aabb box_of(const Volume& volume, const Cell& cell, double margin) const {
    Aabb box;
    for (const double side : {-margin, 1 + margin}) {
      const double off = side * cell.size;
      box.add(to_float(lower_ +
                       Vec3d{cell.at[0] + off, cell.at[1] + off, cell.at[2] + off} * volume.step));
    }
    return box;
  }

  void add_cells(Volume& volume, const Cell& cell) {
    if (!overlaps_any(ways_, box_of(volume, cell, 0))) return;
    if (cell.size == 1 || !overlaps_any(tree_, box_of(volume, cell, 0.5))) {
      volume.cells.push_back(cell);
      return;
    }
    const std::uint32_t half = cell.size / 2;
    for (std::uint32_t k = 0; k < 8; ++k) {
      add_cells(volume, {at_corner(cell.at, half, k), half, {}});
    }
  }

  static Lattice at_corner(const Lattice& at, std::uint32_t size, std::uint32_t k) {
    return {at[0] + (k & 1u) * size, at[1] + (k >> 1 & 1u) * size, at[2] + (k >> 2 & 1u) * size};
  }

  /// One probe for all corners at one place.
  void add_corners(Volume& volume) {
    const auto by_place = [](const Lattice& a, const Lattice& b) {
      return std::lexicographical_compare(a.rbegin(), a.rend(), b.rbegin(), b.rend());
    };
    std::sort(volume.cells.begin(), volume.cells.end(),
              [&](const Cell& a, const Cell& b) { return by_place(a.at, b.at); });
    std::vector<Lattice> corners;
    for (const Cell& cell : volume.cells) {
      for (std::uint32_t k = 0; k < 8; ++k) corners.push_back(at_corner(cell.at, cell.size, k));
    }
    std::sort(corners.begin(), corners.end(), by_place);
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    const auto first = static_cast<std::uint32_t>(grid_.positions.size());
    for (Cell& cell : volume.cells) {
      for (std::uint32_t k = 0; k < 8; ++k) {
        const auto found = std::lower_bound(corners.begin(), corners.end(),
                                            at_corner(cell.at, cell.size, k), by_place);
        cell.probe[k] = first + static_cast<std::uint32_t>(found - corners.begin());
      }
    }
    for (const Lattice& at : corners) {
      grid_.positions.push_back(volume.origin + Vec3d{static_cast<double>(at[0]),
                                                      static_cast<double>(at[1]),
                                                      static_cast<double>(at[2])} *
                                                    volume.step);
    }
  }

  const scene::Scene& scene_;
  const Hierarchy& tree_;
  const GridOptions& options_;
  Hierarchy ways_;  // over the boxes that moving meshes sweep, recentred
  Vec3d lower_;     // of the volume at work, recentred
  ProbeGrid grid_;
};

}  // namespace

ProbeGrid place_probes(const scene::Scene& scene, const Hierarchy& tree,
                       const GridOptions& options) {
  if (scene.moving.empty()) return {};
  return Placing(scene, tree, options).run();
}

}  // namespace lightbatch::probes
