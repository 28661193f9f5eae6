// H. Ylitie, T. Karras, S. Laine: Efficient Incoherent Ray Traversal on GPUs Through Compressed
// Wide BVHs, HPG 2017, section 3: the cheapest 8-wide tree over a given binary one by dynamic
// programming over (node, number of places it may fill). Boxes stay uncompressed.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>

#include "core/base/check.h"
#include "core/rays/casting_costs.h"
#include "core/rays/wide_tree.h"

namespace lightbatch::rays {
namespace {

using hierarchy::Hierarchy;
using NodeId = Hierarchy::NodeId;

constexpr std::uint32_t kLeastInGrid = 64;  // triangles
// Beyond, products in the walk through a grid might leave the range of floats.
constexpr float kMostReach = 1e18f;
constexpr std::uint32_t kMaxLeaf = 8;
constexpr std::size_t kUsualBytes = 56;  // a triangle

/// Cheapest ways to put a subtree into 1..8 places of a wide node.
struct Plan {
  float cost[kWidth];            // [i]: at most i + 1 places
  std::uint8_t to_left[kWidth];  // places of the left child; 0: same as with one place fewer
  bool leaf = false;             // with one place: a leaf instead of a wide node
  bool grid = false;             // or a grid
  bool filtered = false;         // holds triangles that ask the filter
  std::uint32_t solid = 0;       // triangles that stop rays
  std::uint32_t leaves = 0;      // that they lie in
  float surface = 0;             // twice their area
};

class Collapse {
 public:
  Collapse(const Hierarchy& tree, std::span<const Vec3f> positions,
           std::span<const std::array<std::uint32_t, 3>> triangles,
           std::span<const Surface> surfaces, Grids grids)
      : tree_(tree),
        positions_(positions),
        triangles_(triangles),
        surfaces_(surfaces),
        grids_(grids) {}

  WideTree run() {
    if (tree_.is_empty()) return std::move(out_);
    const Aabb box = tree_.box(0);
    for (std::size_t k = 0; k < 3; ++k) {
      out_.reach[k] = std::max(std::abs(box.lower[k]), std::abs(box.upper[k]));
      if (!(out_.reach[k] < kMostReach)) grids_ = Grids::kNever;
    }
    plan();
    if (plans_[0].solid == 0) return std::move(out_);
    out_.data.reserve(kUsualBytes * std::size_t{plans_[0].solid} + sizeof(WideNode) + 64);
    out_.empty = false;
    emit();
    append(nullptr, kWidth * sizeof(float));
    LB_CHECK(out_.data.size() < Child::kMaxPlace * Child::kUnit,
             "more triangles than a caster can hold");
    out_.data.shrink_to_fit();
    return std::move(out_);
  }

 private:
  Surface surface(std::uint32_t triangle) const {
    return surfaces_.empty() ? Surface::kOpaque : surfaces_[triangle];
  }

  float twice_area(std::uint32_t triangle) const {
    const auto& [a, b, c] = triangles_[triangle];
    return length(cross(positions_[b] - positions_[a], positions_[c] - positions_[a]));
  }

  void plan() {
    plans_.resize(tree_.node_count());
    for (NodeId i = tree_.node_count(); i-- > 0;) {
      Plan& p = plans_[i];
      const float area = tree_.box(i).area();
      if (tree_.is_leaf(i)) {
        p.solid = surface(tree_.primitive(tree_.first(i))) == Surface::kClear ? 0 : 1;
        p.filtered = surface(tree_.primitive(tree_.first(i))) == Surface::kFiltered;
        p.leaves = p.solid;
        p.leaf = true;
        const float cost = p.solid == 0 ? 0.0f : area * (kLeafCost + kTriangleCost);
        if (p.solid != 0) p.surface = twice_area(tree_.primitive(tree_.first(i)));
        std::fill_n(p.cost, kWidth, cost);
        std::fill_n(p.to_left, kWidth, std::uint8_t{0});
        continue;
      }
      const Plan& left = plans_[tree_.left(i)];
      const Plan& right = plans_[tree_.right(i)];
      p.solid = left.solid + right.solid;
      p.surface = left.surface + right.surface;
      p.filtered = left.filtered || right.filtered;
      for (std::size_t places = 2; places <= kWidth; ++places) {
        float best = std::numeric_limits<float>::infinity();
        std::uint8_t choice = 1;
        for (std::size_t k = 1; k < places; ++k) {
          const float cost = left.cost[k - 1] + right.cost[places - k - 1];
          if (cost < best) {
            best = cost;
            choice = static_cast<std::uint8_t>(k);
          }
        }
        p.cost[places - 1] = best;
        p.to_left[places - 1] = choice;
      }
      const float as_node = area * kNodeCost + p.cost[kWidth - 1];
      const float as_leaf = p.solid == 0 ? 0.0f
                            : p.solid <= kMaxLeaf
                                ? area * (kLeafCost + kTriangleCost * static_cast<float>(p.solid))
                                : std::numeric_limits<float>::infinity();
      p.leaf = p.solid <= kMaxLeaf && !(as_node < as_leaf);
      p.leaves = p.leaf ? std::min(p.solid, 1u) : left.leaves + right.leaves;
      p.cost[0] = p.leaf ? as_leaf : as_node;
      if (grids_ != Grids::kNever && !p.leaf) consider_grid(i);
      p.to_left[0] = 0;
      // [kWidth - 1] keeps its own split: it is what the node itself uses as a root.
      for (std::size_t places = 2; places < kWidth; ++places) {
        if (!(p.cost[places - 1] < p.cost[places - 2])) {
          p.cost[places - 1] = p.cost[places - 2];
          p.to_left[places - 1] = 0;
        }
      }
    }
  }

  /// The leaves below node i in the casting tree.
  std::vector<GridMember> members_of(NodeId i, std::vector<NodeId>& leaves) const {
    std::vector<GridMember> members;
    std::vector<NodeId> open{i};
    while (!open.empty()) {
      const NodeId n = open.back();
      open.pop_back();
      if (plans_[n].solid == 0) continue;
      if (plans_[n].leaf) {
        leaves.push_back(n);
        members.push_back({tree_.box(n), plans_[n].solid, 0});
        continue;
      }
      open.push_back(tree_.right(n));
      open.push_back(tree_.left(n));
    }
    return members;
  }

  /// Makes node i a grid if that is cheaper. Filters may be asked only once about a triangle, and
  /// grids may come upon one twice.
  void consider_grid(NodeId i) {
    Plan& p = plans_[i];
    if (p.solid < kLeastInGrid || p.filtered) return;
    if (grids_ == Grids::kEverywhere) {
      p.grid = true;
      std::fill_n(p.to_left, kWidth, std::uint8_t{0});  // never opened
      return;
    }
    float cost = least_grid_cost(tree_.box(i), p.leaves);
    if (cost < p.cost[0]) {
      std::vector<NodeId> leaves;
      cost = plan_grid(tree_.box(i), members_of(i, leaves)).cost;
    }
    if (cost < p.cost[0]) {
      p.grid = true;
      p.cost[0] = cost;
    } else if (const float share = cost / p.cost[0];
               out_.refused.triangles == 0 || share < out_.refused.cost_share) {
      out_.refused = {i, p.solid, 0, share};
    }
  }

  struct Part {
    NodeId node;
    std::size_t places;
  };

  /// The children of node i as a wide node.
  std::size_t children(NodeId i, NodeId* result) const {
    std::size_t count = 0;
    std::array<Part, 2 * kWidth> stack;
    std::size_t size = 0;
    const auto push_halves = [&](NodeId node, std::size_t places) {
      const std::size_t left = plans_[node].to_left[places - 1];
      stack[size++] = {tree_.right(node), places - left};
      stack[size++] = {tree_.left(node), left};
    };
    push_halves(i, kWidth);
    while (size > 0) {
      Part part = stack[--size];
      const Plan& p = plans_[part.node];
      if (p.solid == 0) continue;
      while (part.places > 1 && p.to_left[part.places - 1] == 0) --part.places;
      if (part.places > 1) {
        push_halves(part.node, part.places);
      } else {
        result[count++] = part.node;
      }
    }
    // Children that stop many rays for what they cost come last, where occlusion begins; the
    // leaves among them first, as they are looked at in the order of their places.
    const auto rank = [&](NodeId node) {
      const Plan& p = plans_[node];
      const float worth = p.surface / p.cost[0];
      return !std::isfinite(worth) ? 0.0f : p.leaf ? -worth : worth;
    };
    std::stable_sort(result, result + count, [&](NodeId a, NodeId b) { return rank(a) < rank(b); });
    return count;
  }

  std::uint32_t write_leaf(NodeId i) {
    std::array<std::uint32_t, kMaxLeaf> members;
    std::uint32_t count = 0;
    for (const std::uint32_t triangle : tree_.primitives(i)) {
      if (surface(triangle) != Surface::kClear) members[count++] = triangle;
    }
    std::array<float, 1 + 10 * kMaxLeaf> leaf;
    std::size_t size = 1;
    Aabb box;
    for (std::uint32_t k = 0; k < count; ++k) {
      for (const std::uint32_t corner : triangles_[members[k]]) box.add(positions_[corner]);
      const bool filtered = surface(members[k]) == Surface::kFiltered;
      leaf[size++] = std::bit_cast<float>(members[k] | (filtered ? WideTree::kFilteredFlag : 0u));
    }
    const Vec3f e = box.extent();
    leaf[0] = (e.x + e.y + e.z) * (1 + 0x1p-20f);
    for (std::size_t j = 0; j < 9; ++j) {
      for (std::uint32_t k = 0; k < count; ++k) {
        leaf[size++] = positions_[triangles_[members[k]][j / 3]][j % 3];
      }
    }
    return Child::leaf(append(leaf.data(), size * sizeof(float)), count);
  }

  std::uint32_t write_grid(NodeId i) {
    std::vector<NodeId> leaves;
    std::vector<GridMember> members = members_of(i, leaves);
    for (std::size_t k = 0; k < leaves.size(); ++k) members[k].word = write_leaf(leaves[k]);
    const GridPlan grid = plan_grid(tree_.box(i), members);
    const std::vector<std::uint32_t> words = fill_grid(grid.layout, members);
    const std::size_t place = append(&grid.layout, sizeof grid.layout);
    append(words.data(), words.size() * sizeof(std::uint32_t), sizeof(std::uint32_t));
    const float otherwise = tree_.box(i).area() * kNodeCost + plans_[i].cost[kWidth - 1];
    out_.grids.push_back({i, plans_[i].solid, grid.layout.cell_count(), grid.cost / otherwise});
    return Child::grid(place);
  }

  /// Where it went. No data: zeros.
  std::size_t append(const void* data, std::size_t bytes, std::size_t alignment = Child::kUnit) {
    const std::size_t end = out_.data.size(), place = (end + alignment - 1) / alignment * alignment;
    out_.data.resize(place + bytes, std::byte{0});
    if (data != nullptr) std::memcpy(out_.data.data() + place, data, bytes);
    return place;
  }

  void emit() {
    struct Pending {
      NodeId node;
      std::size_t parent;  // place of its reference
    };
    constexpr std::size_t kNone = ~std::size_t{0};
    std::vector<Pending> stack{{0, kNone}};
    while (!stack.empty()) {
      const Pending pending = stack.back();
      stack.pop_back();
      WideNode node;
      std::array<NodeId, kWidth> members{pending.node};
      const auto is_inner = [&](NodeId n) { return !plans_[n].leaf && !plans_[n].grid; };
      const std::size_t count = is_inner(pending.node) ? children(pending.node, members.data()) : 1;
      const std::size_t own = append(nullptr, sizeof node, alignof(WideNode));
      for (std::size_t place = 0; place < kWidth; ++place) {
        const Aabb box = place < count ? tree_.box(members[place]) : Aabb();
        for (std::size_t axis = 0; axis < 3; ++axis) {
          node.lower[axis][place] = box.lower[axis];
          node.upper[axis][place] = box.upper[axis];
        }
        node.child[place] = place >= count                ? 0
                            : plans_[members[place]].leaf ? write_leaf(members[place])
                            : plans_[members[place]].grid ? write_grid(members[place])
                                                          : 0;
      }
      std::memcpy(out_.data.data() + own, &node, sizeof node);
      if (pending.parent != kNone) {
        const auto word = static_cast<std::uint32_t>(own / Child::kUnit);
        std::memcpy(out_.data.data() + pending.parent, &word, sizeof word);
      }
      for (std::size_t place = count; place-- > 0;) {
        if (is_inner(members[place])) {
          stack.push_back({members[place], own + offsetof(WideNode, child) + 4 * place});
        }
      }
    }
  }

  const Hierarchy& tree_;
  std::span<const Vec3f> positions_;
  std::span<const std::array<std::uint32_t, 3>> triangles_;
  std::span<const Surface> surfaces_;
  Grids grids_;
  std::vector<Plan> plans_;
  WideTree out_;
};

}  // namespace

WideTree collapse(const hierarchy::Hierarchy& tree, std::span<const Vec3f> positions,
                  std::span<const std::array<std::uint32_t, 3>> triangles,
                  std::span<const Surface> surfaces, Grids grids) {
  return Collapse(tree, positions, triangles, surfaces, grids).run();
}

}  // namespace lightbatch::rays
