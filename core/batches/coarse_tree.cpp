#include "core/batches/coarse_tree.h"

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
  out.reserve(std::max(a.size(), b.size()));
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

CoarseTree make_coarse_tree(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
                            const std::vector<bool>& merged_triangle, const KeyMap& keys,
                            const Profile& profile, std::uint32_t max_vertices,
                            const ViewDistribution& views) {
  CoarseTree coarse;
  if (tree.is_empty()) return coarse;
  std::vector<std::uint32_t> before(tree.primitive_count() + 1, 0);
  for (std::uint32_t k = 0; k < tree.primitive_count(); ++k)
    before[k + 1] = before[k] + (merged_triangle[tree.primitive(k)] ? 1 : 0);
  const auto count = [&](std::uint32_t node) {
    return before[tree.first(node) + tree.count(node)] - before[tree.first(node)];
  };
  const std::uint32_t total = count(0);
  if (total == 0) return coarse;
  const std::uint32_t leaf_size =
      std::max(std::clamp(total / kLeavesWanted, 1u, kLargestLeaf), total / kMostLeaves);

  // (hierarchy node, coarse parent to be told where its right child is, or kNone).
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
    const std::uint32_t id = coarse.size();
    coarse.node.push_back(node);
    coarse.tree.right.push_back(0);
    if (parent != scene::kNone) coarse.tree.right[parent] = id;
    if (tree.is_leaf(node) || count(node) <= leaf_size) continue;
    stack.emplace_back(tree.right(node), id);
    stack.emplace_back(tree.left(node), scene::kNone);
  }

  // Level by level from the leaves: each node merges its children's shares and frees them.
  std::vector<std::uint32_t> height(coarse.size(), 0);
  std::vector<std::vector<std::uint32_t>> levels;
  for (std::uint32_t i = coarse.size(); i-- > 0;) {
    if (!coarse.tree.is_leaf(i))
      height[i] = 1 + std::max(height[i + 1], height[coarse.tree.right[i]]);
    if (height[i] >= levels.size()) levels.resize(height[i] + 1);
    levels[height[i]].push_back(i);
  }
  std::vector<std::vector<Share>> shares(coarse.size());
  coarse.cost.resize(coarse.size());
  for (const auto& level : levels) {
    parallel_for(level.size(), 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const std::uint32_t i = level[k];
        const std::uint32_t right = coarse.tree.right[i];
        if (right == 0) {
          shares[i] = leaf_shares(scene, tree.primitives(coarse.node[i]), merged_triangle, keys);
        } else {
          shares[i] = merge_shares(shares[i + 1], shares[right]);
          shares[i + 1] = {};
          shares[right] = {};
        }
        for (const Share& s : shares[i]) {
          const ShareCost c = cost_of(s, views.visible(s.box), profile, max_vertices);
          coarse.cost[i].draws += c.draws;
          coarse.cost[i].triangles += c.triangles;
          coarse.cost[i].cost += c.cost;
        }
      }
    });
  }
  return coarse;
}

}  // namespace lightbatch::batches
