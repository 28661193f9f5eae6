#include "core/hierarchy/linked_tree.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/parallel.h"

namespace lightbatch::hierarchy {
namespace {

constexpr std::size_t kGrain = 1024;  // subtrees

/// Of a subtree in the arrays.
struct Place {
  std::uint32_t node, first;
  bool operator==(const Place&) const = default;
};

void copy_subtree(const TreeArrays& in, Place from, TreeArrays& out, Place to,
                  std::uint32_t count) {
  for (std::uint32_t k = 0; k < 2 * count - 1; ++k) {
    TreeNode node = in.nodes[from.node + k];
    node.first += to.first - from.first;  // may wrap on its way
    out.nodes[to.node + k] = node;
  }
  std::copy_n(in.primitives.begin() + from.first, count, out.primitives.begin() + to.first);
}

/// Whether a leaf below node `root` lies more than `levels` deeper.
bool is_deeper(const TreeNodes& nodes, std::uint32_t root, int levels) {
  if (static_cast<std::int64_t>(nodes[root].count) - 1 <= levels) return false;
  struct Entry {
    std::uint32_t node;
    int levels;
  };
  std::vector<Entry> open{{root, levels}};
  while (!open.empty()) {
    const Entry top = open.back();
    open.pop_back();
    if (static_cast<std::int64_t>(nodes[top.node].count) - 1 <= top.levels) continue;
    if (top.levels == 0) return true;
    open.push_back({top.node + 1, top.levels - 1});
    open.push_back({top.node + 2 * nodes[top.node + 1].count, top.levels - 1});
  }
  return false;
}

}  // namespace

LinkedTree::LinkedTree(const TreeArrays& tree, float least_area)
    : tree_(tree), nodes_(2), parents_(1, 0), heights_(2, 0) {
  struct Link {
    std::uint32_t node;
    Slot slot;
  };
  std::vector<Link> open{{0, 0}};
  std::vector<Slot> inner;  // parents before children
  while (!open.empty()) {
    const auto [i, slot] = open.back();
    open.pop_back();
    const TreeNode& t = tree.nodes[i];
    nodes_[slot] = {{t.lower[0], t.lower[1], t.lower[2]},
                    kLeaf | i,
                    {-t.upper[0], -t.upper[1], -t.upper[2]},
                    t.count};
    if (t.count == 1 || (slot != 0 && box(slot).area() < least_area)) continue;
    const Slot pair = slot_count();
    nodes_[slot].link = pair;
    nodes_.resize(pair + 2);
    heights_.resize(pair + 2);
    parents_.push_back(slot);
    inner.push_back(slot);
    open.push_back({i + 2 * tree.nodes[i + 1].count, pair + 1});
    open.push_back({i + 1, pair});
  }
  for (std::size_t k = inner.size(); k-- > 0;) {
    heights_[inner[k]] = height_of_pair(nodes_[inner[k]].link);
  }
  merged_costs_.resize(nodes_.size());
  for (Slot i = 0; i < slot_count(); ++i) {
    if (is_leaf(i) && count(i) <= kMergedLeaf) {
      merged_costs_[i] = merged_cost_below(nodes_[i].link & ~kLeaf);
    }
  }
  for (std::size_t k = inner.size(); k-- > 0;) refit_merged_cost(inner[k]);
}

std::uint8_t LinkedTree::height_of_pair(Slot pair) const {
  return static_cast<std::uint8_t>(1 + std::max(heights_[pair], heights_[pair + 1]));
}

float LinkedTree::merged_cost_below(std::uint32_t node) const {
  const TreeNode* nodes = &tree_.nodes[node];
  std::array<float, 2 * kMergedLeaf> cost;
  for (std::uint32_t k = 2 * nodes->count - 1; k-- > 0;) {  // children first
    const TreeNode& n = nodes[k];
    const float area =
        half_area(n.upper[0] - n.lower[0], n.upper[1] - n.lower[1], n.upper[2] - n.lower[2]);
    cost[k] = area * static_cast<float>(n.count);
    if (n.count == 1) continue;
    cost[k] = std::min(cost[k], area + cost[k + 1] + cost[k + 2 * nodes[k + 1].count]);
  }
  return cost[0];
}

void LinkedTree::refit_merged_cost(Slot i) {
  if (count(i) > kMergedLeaf) return;
  const Slot pair = child(i);
  const float area = box(i).area();
  merged_costs_[i] =
      area + merged_costs_[pair] + merged_costs_[pair + 1] - saved_by_merging(pair, pair + 1, area);
}

void LinkedTree::copy_node(Slot to, Slot from) {
  nodes_[to] = nodes_[from];
  merged_costs_[to] = merged_costs_[from];
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
    refit_merged_cost(i);
    if (i == 0) return;
    i = parent(i);
  }
}

double LinkedTree::cost() const {
  double sum = 0;
  for (Slot i = 0; i < slot_count(); ++i) {
    if (count(i) <= kMergedLeaf) {
      const bool counted = i != 0 && count(parent(i)) <= kMergedLeaf;  // in its parent's
      sum += counted ? 0 : static_cast<double>(merged_cost(i));
    } else if (!is_leaf(i)) {
      sum += static_cast<double>(box(i).area());
    }
  }
  return sum;
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

struct LinkedTree::Part {
  Slot slot;
  Place at;
  int depth;
};

bool LinkedTree::write(TreeArrays& tree) const {
  // The top and, below it, the subtrees that it holds.
  std::vector<Part> open{{0, {0, 0}, 0}}, inner, leaves;
  while (!open.empty()) {
    const Part part = open.back();
    open.pop_back();
    if (is_leaf(part.slot)) {
      leaves.push_back(part);
      continue;
    }
    inner.push_back(part);
    const Slot left = child(part.slot);
    const auto [node, first] = part.at;
    open.push_back({left + 1, {node + 2 * count(left), first + count(left)}, part.depth + 1});
    open.push_back({left, {node + 1, first}, part.depth + 1});
  }
  const auto root = [&](const Part& part) { return nodes_[part.slot].link & ~kLeaf; };
  const int too_deep = deterministic_reduce(
      leaves.size(), kGrain, 0,
      [&](std::size_t begin, std::size_t end) {
        int deep = 0;
        for (std::size_t i = begin; i < end; ++i) {
          const int levels = kMaxDepth - leaves[i].depth;
          // Most have too few primitives to be looked at.
          if (static_cast<std::int64_t>(count(leaves[i].slot)) - 1 <= levels) continue;
          deep += is_deeper(tree.nodes, root(leaves[i]), levels) ? 1 : 0;
        }
        return deep;
      },
      [](int a, int b) { return a + b; });
  if (too_deep > 0) return false;

  struct Copy {
    Place from, aside, to;
    std::uint32_t count;
  };
  std::vector<Copy> copies;
  std::uint32_t moved = 0;
  for (const Part& part : leaves) {
    const Place from{root(part), tree.nodes[root(part)].first};
    copies.push_back({from, {2 * moved, moved}, part.at, count(part.slot)});
    if (from != part.at) moved += count(part.slot);
  }
  const auto each_copy = [&](auto body) {
    parallel_for(copies.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) body(copies[i]);
    });
  };
  // Fresh memory costs more than a second copy of few.
  if (moved <= count(0) / 2) {
    TreeArrays aside(moved + 1);
    each_copy([&](const Copy& c) {
      if (c.from != c.to) copy_subtree(tree, c.from, aside, c.aside, c.count);
    });
    each_copy([&](const Copy& c) {
      if (c.from != c.to) copy_subtree(aside, c.aside, tree, c.to, c.count);
    });
  } else {
    TreeArrays out(count(0));
    each_copy([&](const Copy& c) { copy_subtree(tree, c.from, out, c.to, c.count); });
    tree = std::move(out);
  }
  for (const Part& part : inner) {
    const Node& node = nodes_[part.slot];
    tree.nodes[part.at.node] = {
        {node.lower[0], node.lower[1], node.lower[2]},
        part.at.first,
        {-node.negated_upper[0], -node.negated_upper[1], -node.negated_upper[2]},
        node.count};
  }
  return true;
}

}  // namespace lightbatch::hierarchy
