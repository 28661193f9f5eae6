#include "core/hierarchy/insertion.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/random.h"
#include "core/hierarchy/split_rule.h"

namespace lightbatch::hierarchy {
namespace {

struct Node {
  Aabb box;
  std::uint32_t count = 1;
  std::uint32_t left = 0;  // leaf: the primitive
  std::uint32_t right = 0;
};

Aabb united(Aabb a, const Aabb& b) {
  a.add(b);
  return a;
}

}  // namespace

std::optional<TreeArrays> build_by_insertion(std::span<const Aabb> boxes) {
  std::vector<std::uint32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0u);
  Random random(1);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  std::vector<Node> nodes{{boxes[order[0]], 1, order[0], 0}};
  nodes.reserve(2 * boxes.size());
  for (std::size_t k = 1; k < order.size(); ++k) {
    const Aabb& box = boxes[order[k]];
    std::uint32_t at = 0;
    for (int depth = 0; nodes[at].count > 1; ++depth) {
      if (depth >= kMaxDepth) return std::nullopt;
      const Node& node = nodes[at];
      const Node &left = nodes[node.left], &right = nodes[node.right];
      const float whole = half_area(united(node.box, box)), own = half_area(node.box);
      const float into_left = half_area(united(left.box, box)) - half_area(left.box);
      const float into_right = half_area(united(right.box, box)) - half_area(right.box);
      // Pairing adds a node as large as the union; going on grows this one and the child.
      if (whole < (whole - own) + std::min(into_left, into_right)) break;
      const std::uint32_t next = into_left <= into_right ? node.left : node.right;
      nodes[at].box.add(box);
      ++nodes[at].count;
      at = next;
    }
    const auto moved = static_cast<std::uint32_t>(nodes.size());
    nodes.push_back(nodes[at]);
    nodes.push_back({box, 1, order[k], 0});
    nodes[at] = {united(nodes[at].box, box), nodes[at].count + 1, moved, moved + 1};
  }
  TreeArrays tree(boxes.size());
  struct Part {
    std::uint32_t node, place, first;
    int depth;
  };
  std::vector<Part> stack{{0, 0, 0, 0}};
  while (!stack.empty()) {
    const Part part = stack.back();
    stack.pop_back();
    if (part.depth > kMaxDepth) return std::nullopt;
    const Node& node = nodes[part.node];
    const Aabb& b = node.box;
    tree.nodes[part.place] = {{b.lower.x, b.lower.y, b.lower.z},
                              part.first,
                              {b.upper.x, b.upper.y, b.upper.z},
                              node.count};
    if (node.count == 1) {
      tree.primitives[part.first] = node.left;
      continue;
    }
    const std::uint32_t on_left = nodes[node.left].count;
    stack.push_back({node.right, part.place + 2 * on_left, part.first + on_left, part.depth + 1});
    stack.push_back({node.left, part.place + 1, part.first, part.depth + 1});
  }
  return tree;
}

}  // namespace lightbatch::hierarchy
