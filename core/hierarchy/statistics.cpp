#include "core/hierarchy/statistics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/hierarchy/split_rule.h"

namespace lightbatch::hierarchy {
namespace {

using NodeId = Hierarchy::NodeId;

double area_of(const Aabb& box) {
  const Vec3d e = to_double(box.upper) - to_double(box.lower);
  return 2 * (e.x * e.y + e.y * e.z + e.z * e.x);
}

double ratio(double part, double whole) { return whole > 0 ? part / whole : 0; }

}  // namespace

Statistics measure(const Hierarchy& tree) {
  Statistics s;
  if (tree.is_empty()) return s;
  s.primitives = tree.primitive_count();
  s.nodes = tree.node_count();
  const double root = area_of(tree.box(0));
  std::vector<int> depth(tree.node_count(), 0);
  double leaf_depths = 0;
  for (NodeId i = 0; i < tree.node_count(); ++i) {
    const auto level = static_cast<std::size_t>(depth[i]);
    if (s.levels.size() <= level) s.levels.resize(level + 1);
    LevelStatistics& row = s.levels[level];
    const double area = ratio(area_of(tree.box(i)), root);
    row.area += area;
    s.sah_cost += area;
    if (tree.is_leaf(i)) {
      ++row.leaves;
      leaf_depths += depth[i];
      continue;
    }
    ++row.inner;
    const NodeId left = tree.left(i), right = tree.right(i);
    depth[left] = depth[right] = depth[i] + 1;
    const double children = ratio(area_of(tree.box(left)) + area_of(tree.box(right)), root);
    row.void_area += std::max(0.0, area - children);
  }
  for (std::size_t level = 0; level < s.levels.size(); ++level) {
    s.levels[level].level = static_cast<int>(level);
    s.void_area += s.levels[level].void_area;
  }
  s.depth = static_cast<int>(s.levels.size()) - 1;
  s.mean_leaf_depth = leaf_depths / s.primitives;
  std::vector<double> merged(tree.node_count());
  for (NodeId i = tree.node_count(); i-- > 0;) {
    const double area = ratio(area_of(tree.box(i)), root);
    merged[i] = tree.count(i) <= kMergedLeaf ? area * tree.count(i)
                                             : std::numeric_limits<double>::infinity();
    if (tree.is_leaf(i)) continue;
    merged[i] = std::min(merged[i], area + merged[tree.left(i)] + merged[tree.right(i)]);
  }
  s.sah_cost_merged = merged[0];
  return s;
}

double effective_partial_overlap(const Hierarchy& tree, std::span<const Vec3f> positions,
                                 std::span<const std::array<std::uint32_t, 3>> triangles,
                                 std::uint32_t samples, std::uint64_t seed) {
  if (tree.is_empty() || samples == 0) return 0;
  const auto corner = [&](std::size_t triangle, std::size_t k) {
    return to_double(positions[triangles[triangle][k]]);
  };
  std::vector<double> sums(triangles.size());
  double total = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const Vec3d a = corner(i, 0);
    total += length(cross(corner(i, 1) - a, corner(i, 2) - a));
    sums[i] = total;
  }
  if (!(total > 0)) return 0;
  std::vector<std::uint32_t> place(triangles.size());
  for (std::uint32_t k = 0; k < tree.primitive_count(); ++k) place[tree.primitive(k)] = k;

  const auto overlaps = [&](std::size_t begin, std::size_t end) {
    double count = 0;
    std::vector<NodeId> stack;
    for (std::size_t sample = begin; sample < end; ++sample) {
      Random random(item_seed(seed, sample));
      const auto found = std::upper_bound(sums.begin(), sums.end(), random.next_double() * total);
      const auto i = static_cast<std::size_t>(
          std::min<std::ptrdiff_t>(found - sums.begin(), std::ssize(sums) - 1));
      const double q = std::sqrt(random.next_double()), r = random.next_double();
      const Vec3f point =
          to_float(corner(i, 0) * (1 - q) + corner(i, 1) * (q * (1 - r)) + corner(i, 2) * (q * r));
      stack.assign(1, 0);
      while (!stack.empty()) {
        const NodeId node = stack.back();
        stack.pop_back();
        const bool own =
            tree.first(node) <= place[i] && place[i] < tree.first(node) + tree.count(node);
        if (!own && !tree.box(node).contains(point)) continue;
        if (!own) count += 1;
        if (tree.is_leaf(node)) continue;
        stack.push_back(tree.left(node));
        stack.push_back(tree.right(node));
      }
    }
    return count;
  };
  return deterministic_reduce(samples, 1024, 0.0, overlaps,
                              [](double a, double b) { return a + b; }) /
         samples;
}

}  // namespace lightbatch::hierarchy
