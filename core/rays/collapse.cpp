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
#include "core/rays/wide_tree.h"

namespace lightbatch::rays {
namespace {

using hierarchy::Hierarchy;
using NodeId = Hierarchy::NodeId;

// Costs of visiting a wide node and a leaf, and of one more triangle in a leaf, tuned by timing
// rays in furnished rooms.
constexpr float kNodeCost = 1.0f;
constexpr float kLeafCost = 0.7f;
constexpr float kTriangleCost = 0.06f;
constexpr std::uint32_t kMaxLeaf = 8;
constexpr std::size_t kUsualBytes = 56;  // a triangle

/// Cheapest ways to put a subtree into 1..8 places of a wide node.
struct Plan {
  float cost[kWidth];            // [i]: at most i + 1 places
  std::uint8_t to_left[kWidth];  // places of the left child; 0: same as with one place fewer
  bool leaf = false;             // with one place: a leaf instead of a wide node
  std::uint32_t solid = 0;       // triangles that stop rays
  float surface = 0;             // twice their area
};

class Collapse {
 public:
  Collapse(const Hierarchy& tree, std::span<const Vec3f> positions,
           std::span<const std::array<std::uint32_t, 3>> triangles,
           std::span<const Surface> surfaces)
      : tree_(tree), positions_(positions), triangles_(triangles), surfaces_(surfaces) {}

  WideTree run() {
    if (tree_.is_empty()) return std::move(out_);
    plan();
    if (plans_[0].solid == 0) return std::move(out_);
    out_.data.reserve(kUsualBytes * std::size_t{plans_[0].solid} + sizeof(WideNode) + 64);
    out_.empty = false;
    emit();
    append(nullptr, kWidth * sizeof(float));
    LB_CHECK(out_.data.size() < Child::kMaxPlace * Child::kUnit,
             "more triangles than a caster can hold");
    out_.data.shrink_to_fit();
    const Aabb box = tree_.box(0);
    for (std::size_t k = 0; k < 3; ++k) {
      out_.reach[k] = std::max(std::abs(box.lower[k]), std::abs(box.upper[k]));
    }
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
      p.cost[0] = p.leaf ? as_leaf : as_node;
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
      const std::size_t count =
          plans_[pending.node].leaf ? 1 : children(pending.node, members.data());
      const std::size_t own = append(nullptr, sizeof node, alignof(WideNode));
      for (std::size_t place = 0; place < kWidth; ++place) {
        const Aabb box = place < count ? tree_.box(members[place]) : Aabb();
        for (std::size_t axis = 0; axis < 3; ++axis) {
          node.lower[axis][place] = box.lower[axis];
          node.upper[axis][place] = box.upper[axis];
        }
        node.child[place] =
            place < count && plans_[members[place]].leaf ? write_leaf(members[place]) : 0;
      }
      std::memcpy(out_.data.data() + own, &node, sizeof node);
      if (pending.parent != kNone) {
        const auto word = static_cast<std::uint32_t>(own / Child::kUnit);
        std::memcpy(out_.data.data() + pending.parent, &word, sizeof word);
      }
      for (std::size_t place = count; place-- > 0;) {
        if (!plans_[members[place]].leaf) {
          stack.push_back({members[place], own + offsetof(WideNode, child) + 4 * place});
        }
      }
    }
  }

  const Hierarchy& tree_;
  std::span<const Vec3f> positions_;
  std::span<const std::array<std::uint32_t, 3>> triangles_;
  std::span<const Surface> surfaces_;
  std::vector<Plan> plans_;
  WideTree out_;
};

}  // namespace

WideTree collapse(const hierarchy::Hierarchy& tree, std::span<const Vec3f> positions,
                  std::span<const std::array<std::uint32_t, 3>> triangles,
                  std::span<const Surface> surfaces) {
  return Collapse(tree, positions, triangles, surfaces).run();
}

}  // namespace lightbatch::rays
