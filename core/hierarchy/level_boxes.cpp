#include "core/hierarchy/level_boxes.h"

#include <utility>

namespace lightbatch::hierarchy {

std::vector<Hierarchy::NodeId> level_nodes(const Hierarchy& tree, int level) {
  std::vector<Hierarchy::NodeId> nodes;
  if (tree.is_empty()) return nodes;
  std::vector<std::pair<Hierarchy::NodeId, int>> stack{{0, 0}};
  while (!stack.empty()) {
    const auto [node, depth] = stack.back();
    stack.pop_back();
    if (depth >= level || tree.is_leaf(node)) {
      nodes.push_back(node);
      continue;
    }
    stack.emplace_back(tree.right(node), depth + 1);
    stack.emplace_back(tree.left(node), depth + 1);
  }
  return nodes;
}

std::vector<Aabb> level_boxes(const Hierarchy& tree, int level) {
  std::vector<Aabb> boxes;
  for (const Hierarchy::NodeId node : level_nodes(tree, level)) boxes.push_back(tree.box(node));
  return boxes;
}

}  // namespace lightbatch::hierarchy
