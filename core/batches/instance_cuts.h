#pragma once

#include <cstdint>
#include <vector>

#include "core/batches/assignment.h"
#include "core/batches/view_tree.h"

namespace lightbatch::batches {

/// The cuts of one mesh that stays shared: its triangles into parts by a hierarchy over the mesh,
/// and for each part the placements into cells by a hierarchy over them. A cell is one draw call of
/// instances of a part. Geometry exists once, whatever the cuts.
class InstanceCuts {
 public:
  /// placements: the objects of each, by primitive, equal in kind from placement to placement.
  /// Splits are looked into while the cheapest cells of a part spend more on triangles than on
  /// draws.
  InstanceCuts(const scene::Scene& scene, const KeyMap& keys,
               std::vector<std::vector<std::uint32_t>> placements, const ViewDistribution& views,
               const Prices& prices);

  Frame solve(const Prices& prices) const;
  /// Appends the parts and cells of the solution.
  void take(const scene::Scene& scene, const KeyMap& keys, const Prices& prices,
            std::vector<InstancePart>& parts, std::vector<InstanceCell>& cells) const;

  const std::vector<std::vector<std::uint32_t>>& placements() const { return placements_; }

 private:
  struct Part {
    std::uint32_t key = 0;
    std::vector<std::uint32_t> triangles;                     // of the first placement, ascending
    std::uint32_t left = scene::kNone, right = scene::kNone;  // into parts_
    ViewTree places;           // over the boxes of the part in every placement
    std::vector<Frame> cells;  // by node of places
  };
  struct Choice {
    double cost = 0;
    std::vector<std::uint32_t> cells;  // nodes of Part::places
  };
  void add_parts(const scene::Scene& scene, const KeyMap& keys, std::uint32_t key,
                 std::vector<std::uint32_t> triangles, const ViewDistribution& views,
                 const Prices& prices);
  /// The boxes of some triangles of the model in every placement.
  std::vector<Aabb> boxes_of(const scene::Scene& scene,
                             const std::vector<std::uint32_t>& triangles) const;
  Part make_part(const scene::Scene& scene, const KeyMap& keys, std::uint32_t key,
                 std::vector<std::uint32_t> triangles, const std::vector<Aabb>& boxes,
                 const ViewDistribution& views) const;
  Choice best_cells(const Part& part, const Prices& prices) const;
  /// Calls visit(part, cells) for every part of the cheapest division.
  template <typename Visit>
  void for_each_chosen(const Prices& prices, const Visit& visit) const;

  std::vector<std::vector<std::uint32_t>> placements_;
  std::size_t model_ = 0;    // the placement of most triangles: others lost some to rounding
  std::vector<Part> parts_;  // children after their parents
  std::vector<std::uint32_t> roots_;  // one for each key
};

}  // namespace lightbatch::batches
