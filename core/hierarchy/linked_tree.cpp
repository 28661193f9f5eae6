#include "core/hierarchy/linked_tree.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/hierarchy/split_rule.h"

namespace lightbatch::hierarchy {
namespace {

constexpr std::size_t kGrain = 8192;

}  // namespace

LinkedTree::LinkedTree(const TreeArrays& tree)
    : nodes_(tree.nodes.size() + 1),
      parents_(tree.nodes.size() / 2 + 1),
      heights_(tree.nodes.size() + 1) {
  const std::size_t n = tree.nodes.size();
  LargeVector<Slot> slots(n);
  slots[0] = 0;
  parents_[0] = 0;
  // The pair of an inner node is its rank among inner nodes in depth-first order.
  const auto pair_of = [&](std::size_t i) {
    return 2 + 2 * (static_cast<Slot>(i) - tree.nodes[i].first);
  };
  parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (tree.nodes[i].count == 1) continue;
      slots[i + 1] = pair_of(i);
      slots[i + 2 * tree.nodes[i + 1].count] = pair_of(i) + 1;
    }
  });
  parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const TreeNode& t = tree.nodes[i];
      const bool leaf = t.count == 1;
      nodes_[slots[i]] = {{t.lower[0], t.lower[1], t.lower[2]},
                          leaf ? kLeaf | tree.primitives[t.first] : pair_of(i),
                          {-t.upper[0], -t.upper[1], -t.upper[2]},
                          t.count};
      if (!leaf) parents_[pair_of(i) / 2] = slots[i];
    }
  });
  nodes_[1] = {};
  for (std::size_t i = n; i-- > 0;) {
    const Slot slot = slots[i];
    heights_[slot] = is_leaf(slot) ? 0 : height_of_pair(nodes_[slot].link);
  }
}

std::uint8_t LinkedTree::height_of_pair(Slot pair) const {
  return static_cast<std::uint8_t>(1 + std::max(heights_[pair], heights_[pair + 1]));
}

void LinkedTree::copy_node(Slot to, Slot from) {
  nodes_[to] = nodes_[from];
  heights_[to] = heights_[from];
  if (!is_leaf(to)) parents_[nodes_[to].link / 2] = to;
}

void LinkedTree::refit_to_root(Slot i) {
  while (true) {
    Node& node = nodes_[i];
    Box b = box(node.link);
    b.add(box(node.link + 1));
    const std::uint32_t count = nodes_[node.link].count + nodes_[node.link + 1].count;
    for (int k = 0; k < 3; ++k) {
      node.lower[k] = b.lower[k];
      node.negated_upper[k] = b.negated_upper[k];
    }
    node.count = count;
    heights_[i] = height_of_pair(node.link);
    if (i == 0) return;
    i = parent(i);
  }
}

void LinkedTree::move(Slot from, Slot to) {
  const Slot sibling = from ^ 1u, above = parent(from), pair = from & ~1u;
  int depth = 1 + std::max(heights_[to], heights_[from]);
  for (Slot i = to; i != 0; i = parent(i), ++depth) {
    if (i == from) return;
  }
  if (depth > kMaxDepth) return;
  copy_node(above, sibling);
  copy_node(sibling, to);
  nodes_[to].link = pair;
  parents_[pair / 2] = to;
  if (above != 0) refit_to_root(parent(above));
  refit_to_root(to);
}

void LinkedTree::write(TreeArrays& tree) const {
  struct Part {
    Slot slot;
    std::uint32_t place, first;
  };
  const auto write_part = [&](const Part& part) {
    const Node& node = nodes_[part.slot];
    tree.nodes[part.place] = {
        {node.lower[0], node.lower[1], node.lower[2]},
        part.first,
        {-node.negated_upper[0], -node.negated_upper[1], -node.negated_upper[2]},
        node.count};
    if ((node.link & kLeaf) != 0) tree.primitives[part.first] = node.link & ~kLeaf;
  };
  const auto left_of = [&](const Part& part) {
    return Part{nodes_[part.slot].link, part.place + 1, part.first};
  };
  const auto right_of = [&](const Part& part) {
    const std::uint32_t on_left = nodes_[nodes_[part.slot].link].count;
    return Part{nodes_[part.slot].link + 1, part.place + 2 * on_left, part.first + on_left};
  };
  // The top by this thread, subtrees by all.
  const std::uint32_t enough = std::max(4096u, nodes_[0].count / 16);
  std::vector<Part> open{{0, 0, 0}}, parts;
  while (!open.empty()) {
    const Part part = open.back();
    open.pop_back();
    if (nodes_[part.slot].count <= enough) {
      parts.push_back(part);
      continue;
    }
    write_part(part);
    open.push_back(left_of(part));
    open.push_back(right_of(part));
  }
  parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end) {
    std::vector<Part> stack;
    for (std::size_t i = begin; i < end; ++i) {
      stack.assign(1, parts[i]);
      while (!stack.empty()) {
        const Part part = stack.back();
        stack.pop_back();
        write_part(part);
        if (is_leaf(part.slot)) continue;
        stack.push_back(right_of(part));
        stack.push_back(left_of(part));
      }
    }
  });
}

}  // namespace lightbatch::hierarchy
