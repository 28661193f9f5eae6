#include "core/batches/key_cuts.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace lightbatch::batches {
namespace {

// Nodes of at most this many triangles are not split: batches of interest are larger by far. Small
// scenes go down to single triangles.
constexpr std::uint32_t kLargestLeaf = 64;
constexpr std::uint32_t kLeavesWanted = 2048;
constexpr std::uint32_t kMostLeaves = 32768;

std::vector<Share> leaf_shares(const scene::Scene& scene, std::span<const std::uint32_t> triangles,
                               const std::vector<bool>& merged, const KeyMap& keys) {
  std::vector<Share> shares;
  for (const std::uint32_t t : triangles) {
    if (!merged[t]) continue;
    const std::uint32_t key = keys.of_triangle[t];
    auto it = std::lower_bound(shares.begin(), shares.end(), key,
                               [](const Share& s, std::uint32_t k) { return s.key < k; });
    if (it == shares.end() || it->key != key) {
      it = shares.insert(it, Share{});
      it->key = key;
    }
    it->triangles += 1;
    it->vertices += keys.vertices_of_object[scene.triangles[t].object];
    for (const Vec3f& p : scene.corners(t)) it->box.add(p);
  }
  return shares;
}

std::vector<Share> merge_shares(const std::vector<Share>& a, const std::vector<Share>& b) {
  std::vector<Share> out;
  out.reserve(a.size() + b.size());
  auto i = a.begin();
  auto j = b.begin();
  while (i != a.end() || j != b.end()) {
    if (j == b.end() || (i != a.end() && i->key < j->key)) {
      out.push_back(*i++);
    } else if (i == a.end() || j->key < i->key) {
      out.push_back(*j++);
    } else {
      out.push_back(*i++);
      out.back().add(*j++);
    }
  }
  return out;
}

}  // namespace

void KeyCuts::make_tree(const hierarchy::Hierarchy& tree,
                        const std::vector<bool>& merged_triangle) {
  std::vector<std::uint32_t> before(tree.primitive_count() + 1, 0);
  for (std::uint32_t k = 0; k < tree.primitive_count(); ++k)
    before[k + 1] = before[k] + (merged_triangle[tree.primitive(k)] ? 1 : 0);
  const auto count = [&](std::uint32_t node) {
    return before[tree.first(node) + tree.count(node)] - before[tree.first(node)];
  };
  const std::uint32_t total = count(0);
  if (total == 0) return;
  const std::uint32_t leaf_size =
      std::max(std::clamp(total / kLeavesWanted, 1u, kLargestLeaf), total / kMostLeaves);
  // (hierarchy node, own parent to be told where its right child is, or kNone).
  std::vector<std::pair<std::uint32_t, std::uint32_t>> stack{{0, scene::kNone}};
  while (!stack.empty()) {
    auto [node, parent] = stack.back();
    stack.pop_back();
    while (!tree.is_leaf(node) && count(node) > leaf_size) {
      if (count(tree.left(node)) == 0)
        node = tree.right(node);
      else if (count(tree.right(node)) == 0)
        node = tree.left(node);
      else
        break;
    }
    const std::uint32_t id = tree_.size();
    node_.push_back(node);
    tree_.right.push_back(0);
    if (parent != scene::kNone) tree_.right[parent] = id;
    if (tree.is_leaf(node) || count(node) <= leaf_size) continue;
    stack.emplace_back(tree.right(node), id);
    stack.emplace_back(tree.left(node), scene::kNone);
  }
}

KeyCuts::KeyCuts(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
                 const std::vector<bool>& merged_triangle, const KeyMap& keys,
                 std::uint32_t max_vertices, const ViewDistribution& views) {
  if (!tree.is_empty()) make_tree(tree, merged_triangle);
  // Level by level from the leaves: each node merges its children's shares and frees them.
  std::vector<std::uint32_t> height(tree_.size(), 0);
  std::vector<std::vector<std::uint32_t>> levels;
  for (std::uint32_t i = tree_.size(); i-- > 0;) {
    if (!tree_.is_leaf(i)) height[i] = 1 + std::max(height[i + 1], height[tree_.right[i]]);
    if (height[i] >= levels.size()) levels.resize(height[i] + 1);
    levels[height[i]].push_back(i);
  }
  std::vector<std::vector<Share>> shares(tree_.size());
  std::vector<std::vector<Entry>> entries(tree_.size());
  for (const auto& level : levels) {
    parallel_for(level.size(), 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const std::uint32_t i = level[k];
        const std::uint32_t right = tree_.right[i];
        if (right == 0) {
          shares[i] = leaf_shares(scene, tree.primitives(node_[i]), merged_triangle, keys);
        } else {
          shares[i] = merge_shares(shares[i + 1], shares[right]);
          shares[i + 1] = {};
          shares[right] = {};
        }
        for (const Share& s : shares[i])
          entries[i].push_back({s.key, frame_of(s, views.chance(s.box), max_vertices)});
      }
    });
  }
  first_.push_back(0);
  for (const auto& list : entries) {
    entries_.insert(entries_.end(), list.begin(), list.end());
    first_.push_back(static_cast<std::uint32_t>(entries_.size()));
  }
}

std::uint32_t KeyCuts::entry(std::uint32_t node, std::uint32_t key) const {
  const auto begin = entries_.begin() + first_[node], end = entries_.begin() + first_[node + 1];
  const auto it =
      std::lower_bound(begin, end, key, [](const Entry& e, std::uint32_t k) { return e.key < k; });
  return it == end || it->key != key ? scene::kNone
                                     : static_cast<std::uint32_t>(it - entries_.begin());
}

KeyCuts::Solution KeyCuts::place(const std::vector<bool>& stop) const {
  Solution solution;
  solution.at.assign(entries_.size(), scene::kNone);
  for (std::uint32_t i = 0; i < tree_.size(); ++i) {
    bool drawn = false;
    for (std::uint32_t e = first_[i]; e < first_[i + 1]; ++e) {
      if (solution.at[e] == scene::kNone && stop[e]) {
        solution.at[e] = i;
        solution.frame += entries_[e].frame;
        drawn = true;
      }
      if (tree_.is_leaf(i)) continue;
      for (const std::uint32_t child : {i + 1, tree_.right[i]})
        if (const std::uint32_t c = entry(child, entries_[e].key); c != scene::kNone)
          solution.at[c] = solution.at[e];
    }
    solution.batches += drawn ? 1u : 0u;
  }
  return solution;
}

KeyCuts::Solution KeyCuts::solve(const Prices& prices) const {
  std::vector<double> best(entries_.size());
  std::vector<bool> stop(entries_.size(), true);
  for (std::uint32_t i = tree_.size(); i-- > 0;) {
    for (std::uint32_t e = first_[i]; e < first_[i + 1]; ++e) {
      best[e] = entries_[e].frame.cost(prices);
      if (tree_.is_leaf(i)) continue;
      const std::uint32_t l = entry(i + 1, entries_[e].key);
      const std::uint32_t r = entry(tree_.right[i], entries_[e].key);
      const double below = (l == scene::kNone ? 0 : best[l]) + (r == scene::kNone ? 0 : best[r]);
      // A key of one child only belongs to that child: its box is the same there.
      stop[e] = l != scene::kNone && r != scene::kNone && best[e] <= below;
      if (!stop[e]) best[e] = below;
    }
  }
  return place(stop);
}

KeyCuts::Solution KeyCuts::solve_within(const Prices& prices, std::uint32_t limit) const {
  Solution solution = solve(prices);
  if (limit == 0 || solution.batches <= limit) return solution;
  std::vector<double> cost(tree_.size(), 0);
  for (std::uint32_t i = 0; i < tree_.size(); ++i)
    for (std::uint32_t e = first_[i]; e < first_[i + 1]; ++e)
      cost[i] += entries_[e].frame.cost(prices);
  std::vector<bool> stop(entries_.size(), false);
  for (const std::uint32_t i : best_cut_within(tree_, cost, limit).nodes)
    for (std::uint32_t e = first_[i]; e < first_[i + 1]; ++e) stop[e] = true;
  return place(stop);
}

std::vector<std::uint32_t> KeyCuts::nodes_of_triangles(
    const Solution& solution, const hierarchy::Hierarchy& tree, const KeyMap& keys,
    const std::vector<bool>& merged_triangle) const {
  std::vector<std::uint32_t> result(merged_triangle.size(), scene::kNone);
  for (std::uint32_t i = 0; i < tree_.size(); ++i) {
    if (!tree_.is_leaf(i)) continue;
    for (const std::uint32_t t : tree.primitives(node_[i]))
      if (merged_triangle[t]) result[t] = solution.at[entry(i, keys.of_triangle[t])];
  }
  return result;
}

}  // namespace lightbatch::batches
