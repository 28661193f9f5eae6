// The sweep of Mueller, Schaefer, Fellner 1999 (try every split, take the cheapest) with the chance
// that a view sees a box in the place of the chance that a ray meets it, its surface area. We try
// no more than kPlaces splits on each axis: a chance is dear beside an area.
#include "core/batches/view_tree.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "core/base/check.h"

namespace lightbatch::batches {
namespace {

constexpr std::size_t kPlaces = 8;
/// Draws that a split adds are counted as no fewer.
constexpr double kLeastDraws = 1e-3;

/// Clusters that differ so little along an axis, as a share of all their box, lie level: rounding.
constexpr float kLevel = 1e-6f;

struct Split {
  double gain = -1;  // triangles saved for each draw added
  std::size_t axis = 0, left = 0;
};

/// Clusters, and what views see of them.
struct Subject {
  std::span<const Aabb> boxes;
  std::span<const double> triangles;
  const ViewDistribution& views;
};

/// The best place on one axis; `order` is sorted along it. chance, all: of everything in it.
Split best_place(const Subject& s, std::span<const std::uint32_t> order, std::size_t axis,
                 double chance, double all) {
  const std::size_t n = order.size(), places = std::min(kPlaces, n - 1);
  const auto place = [&](std::size_t k) { return (k + 1) * n / (places + 1); };
  std::array<double, kPlaces> right;
  Aabb box;
  std::size_t at = n;
  for (std::size_t k = places; k-- > 0;) {
    while (at > place(k)) box.add(s.boxes[order[--at]]);
    right[k] = s.views.visible(box);
  }
  Split best;
  best.axis = axis;
  box = {};
  at = 0;
  double before = 0;
  for (std::size_t k = 0; k < places; ++k) {
    for (; at < place(k); ++at) {
      box.add(s.boxes[order[at]]);
      before += s.triangles[order[at]];
    }
    const double left = s.views.visible(box);
    const double saved = chance * all - left * before - right[k] * (all - before);
    const double gain = saved / std::max(left + right[k] - chance, kLeastDraws);
    if (gain > best.gain) {
      best.gain = gain;
      best.left = at;
    }
  }
  return best;
}

}  // namespace

ViewTree split_by_views(std::span<const Aabb> boxes, std::span<const double> triangles,
                        const ViewDistribution& views) {
  LB_CHECK(boxes.size() == triangles.size(), "one box for each cluster");
  const Subject subject{boxes, triangles, views};
  ViewTree result;
  const auto n = static_cast<std::uint32_t>(triangles.size());
  if (n == 0) return result;
  result.order.resize(n);
  std::iota(result.order.begin(), result.order.end(), 0u);
  struct Entry {
    std::uint32_t first, count, parent;  // parent: to be told of its right child, or kNone
  };
  std::vector<Entry> stack{{0, n, scene::kNone}};
  while (!stack.empty()) {
    const auto [first, count, parent] = stack.back();
    stack.pop_back();
    const std::uint32_t id = result.tree.size();
    if (parent != scene::kNone) result.tree.right[parent] = id;
    const auto members = std::span(result.order).subspan(first, count);
    Aabb whole;
    double all = 0;
    for (const std::uint32_t c : members) {
      whole.add(boxes[c]);
      all += triangles[c];
    }
    result.tree.right.push_back(0);
    result.box.push_back(whole);
    result.first.push_back(first);
    result.count.push_back(count);
    if (count == 1) continue;
    std::array<std::vector<std::uint32_t>, 3> orders;
    std::array<Split, 3> splits;
    const double chance = views.visible(whole);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      orders[axis].assign(members.begin(), members.end());
      std::sort(orders[axis].begin(), orders[axis].end(), [&](std::uint32_t a, std::uint32_t b) {
        const Aabb &p = boxes[a], &q = boxes[b];
        const float ca = p.lower[axis] + p.upper[axis], cb = q.lower[axis] + q.upper[axis];
        return ca != cb ? ca < cb : a < b;
      });
      const Aabb &p = boxes[orders[axis].front()], &q = boxes[orders[axis].back()];
      const float spread = q.lower[axis] + q.upper[axis] - p.lower[axis] - p.upper[axis];
      if (spread <= kLevel * whole.diagonal()) continue;
      splits[axis] = best_place(subject, orders[axis], axis, chance, all);
    }
    const Split* best = &splits[0];
    for (const Split& s : splits)
      if (s.gain > best->gain) best = &s;
    const auto left = best->left == 0 ? count / 2 : static_cast<std::uint32_t>(best->left);
    std::copy(orders[best->axis].begin(), orders[best->axis].end(), members.begin());
    stack.push_back({first + left, count - left, id});
    stack.push_back({first, left, scene::kNone});
  }
  return result;
}

}  // namespace lightbatch::batches
