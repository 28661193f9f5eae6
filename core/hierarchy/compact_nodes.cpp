#include "core/hierarchy/compact_nodes.h"

namespace lightbatch::hierarchy {
namespace {

Aabb box_of(const TreeNode& n) {
  return {{n.lower[0], n.lower[1], n.lower[2]}, {n.upper[0], n.upper[1], n.upper[2]}};
}
float plane(const TreeNode& n, std::size_t k) { return k < 3 ? n.lower[k] : n.upper[k - 3]; }

}  // namespace

CompactNodes::CompactNodes(std::span<const TreeNode> nodes)
    : blocks_((nodes.size() + 63) / 64), boxes_((nodes.size() + 1) / 2), inner_(nodes.size() / 2) {
  const auto count = static_cast<std::uint32_t>(nodes.size());
  for (std::uint32_t i = 0; i < count; ++i) {
    if (i % 64 == 0) blocks_[i / 64].before = nodes[i].first;
    if (nodes[i].count != 1) continue;
    blocks_[i / 64].leaves |= std::uint64_t{1} << (i % 64);
    boxes_[nodes[i].first] = box_of(nodes[i]);
  }
  // Children before parents.
  for (std::uint32_t i = count; i-- > 0;) {
    const TreeNode& node = nodes[i];
    if (node.count == 1) continue;
    Inner& inner = inner_[i - node.first];
    if (node.count <= kMostInBytes) {
      inner = small_node(nodes, i);
      continue;
    }
    const auto place = static_cast<std::uint32_t>(large_.size());
    for (std::size_t k = 0; k < 4; ++k) inner.leaf[k] = static_cast<std::uint8_t>(place >> (8 * k));
    inner.last = 0;
    large_.push_back({box_of(node), node.count});
  }
  large_.shrink_to_fit();
}

CompactNodes::Inner CompactNodes::small_node(std::span<const TreeNode> nodes,
                                             std::uint32_t i) const {
  const std::uint32_t left = i + 1, right = i + 2 * nodes[left].count;
  Inner inner;
  inner.last = static_cast<std::uint8_t>(nodes[i].count - 1);
  for (std::size_t k = 0; k < 6; ++k) {
    const bool in_left = plane(nodes[left], k) == plane(nodes[i], k);
    const std::uint32_t child = in_left ? left : right;
    const std::uint32_t within =
        nodes[child].count == 1 ? 0u : inner_[child - nodes[child].first].leaf[k];
    inner.leaf[k] = static_cast<std::uint8_t>((in_left ? 0u : nodes[left].count) + within);
  }
  return inner;
}

Aabb CompactNodes::box(std::uint32_t i) const {
  const std::uint32_t begin = first(i);
  if (is_leaf(i)) return boxes_[begin];
  const Inner& node = inner_[i - begin];
  if (node.is_large()) return large_[node.large()].box;
  const Aabb* leaves = &boxes_[begin];
  return {
      {leaves[node.leaf[0]].lower.x, leaves[node.leaf[1]].lower.y, leaves[node.leaf[2]].lower.z},
      {leaves[node.leaf[3]].upper.x, leaves[node.leaf[4]].upper.y, leaves[node.leaf[5]].upper.z}};
}

std::size_t CompactNodes::memory_bytes() const {
  return blocks_.capacity() * sizeof(Block) + boxes_.capacity() * sizeof(Aabb) +
         inner_.capacity() * sizeof(Inner) + large_.capacity() * sizeof(Large);
}

}  // namespace lightbatch::hierarchy
