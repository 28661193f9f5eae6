#include "core/batches/problem.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <span>

#include "core/base/parallel.h"

namespace lightbatch::batches {
namespace {

std::vector<bool> merged_triangles(const scene::Scene& scene, const Fates& fates) {
  std::vector<bool> merged(scene.triangles.size());
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t)
    merged[t] = fates.of_object[scene.triangles[t].object] == Fate::kMerged;
  return merged;
}

/// Blended objects that the cut keeps in one piece stay in their nodes.
void leave_whole_blended(const scene::Scene& scene, std::vector<std::uint32_t>& node_of,
                         std::vector<Fate>& fate) {
  for (std::uint32_t o = 0; o < scene.objects.size(); ++o) {
    if (fate[o] != Fate::kMerged || !is_blended(scene, o)) continue;
    const scene::Object& object = scene.objects[o];
    const auto nodes = std::span(node_of).subspan(object.first_triangle, object.triangle_count);
    if (std::adjacent_find(nodes.begin(), nodes.end(), std::not_equal_to<>()) != nodes.end())
      continue;
    std::fill(nodes.begin(), nodes.end(), scene::kNone);
    fate[o] = Fate::kLeft;
  }
}

/// Batches from the node of the cut that draws each triangle. number: by node, its batch or kNone.
void fill_batches(const scene::Scene& scene, const KeyMap& keys,
                  const std::vector<std::uint32_t>& node_of, const KeyCuts& cuts,
                  std::vector<std::uint32_t>& number, BatchPlan& result) {
  struct Slot {
    std::uint32_t key;
    Group group;
  };
  std::vector<std::vector<Slot>> slots(cuts.tree().size());
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
    const std::uint32_t b = node_of[t];
    if (b == scene::kNone) continue;
    const std::uint32_t key = keys.of_triangle[t];
    const std::uint32_t object = scene.triangles[t].object;
    auto it = std::lower_bound(slots[b].begin(), slots[b].end(), key,
                               [](const Slot& s, std::uint32_t k) { return s.key < k; });
    if (it == slots[b].end() || it->key != key) {
      it = slots[b].insert(it, Slot{key, {}});
      it->group.material = scene.objects[object].material;
      it->group.layout = keys.keys[key].layout;
      it->group.page = keys.keys[key].page;
    }
    Group& group = it->group;
    if (group.pieces.empty() || group.pieces.back().object != object) {
      group.pieces.push_back({object, {}});
      group.coloured = group.coloured || scene.objects[object].material != group.material;
    }
    auto& ranges = group.pieces.back().ranges;
    if (!ranges.empty() && ranges.back().first + ranges.back().count == t)
      ++ranges.back().count;
    else
      ranges.push_back({t, 1});
    group.triangles += 1;
    group.vertices += keys.vertices_of_object[object];
    for (const Vec3f& p : scene.corners(t)) group.box.add(p);
  }
  number.assign(slots.size(), scene::kNone);
  for (std::uint32_t b = 0; b < slots.size(); ++b) {
    if (slots[b].empty()) continue;
    number[b] = static_cast<std::uint32_t>(result.batches.size());
    Batch batch;
    for (Slot& slot : slots[b]) {
      batch.box.add(slot.group.box);
      batch.groups.push_back(std::move(slot.group));
    }
    result.batches.push_back(std::move(batch));
  }
}

/// The nodes of the cuts' tree at and above batches, without those that hold one thing only.
void fill_tree(const KeyCuts& cuts, const std::vector<std::uint32_t>& number, BatchPlan& result) {
  if (result.batches.empty()) return;
  const CutTree& tree = cuts.tree();
  std::vector<std::uint32_t> alive(tree.size(), 0);  // batches at or under the node
  for (std::uint32_t i = tree.size(); i-- > 0;) {
    alive[i] = number[i] == scene::kNone ? 0 : 1;
    if (!tree.is_leaf(i)) alive[i] += alive[i + 1] + alive[tree.right[i]];
  }
  struct Entry {
    std::uint32_t node, parent;
    bool batch;  // the batch of the node, not the node
  };
  std::vector<Entry> stack{{0, scene::kNone, false}};
  while (!stack.empty()) {
    auto [node, parent, batch] = stack.back();
    stack.pop_back();
    while (!batch && number[node] == scene::kNone) {
      const std::uint32_t l = node + 1, r = tree.right[node];
      if (alive[l] == 0)
        node = r;
      else if (alive[r] == 0)
        node = l;
      else
        break;
    }
    const auto id = static_cast<std::uint32_t>(result.tree.size());
    if (parent != scene::kNone) result.tree[parent].children.push_back(id);
    result.tree.emplace_back();
    if (batch || (alive[node] == 1 && number[node] != scene::kNone)) {
      result.tree.back().batch = number[node];
      continue;
    }
    // Last in, first out: the node's own batch comes first.
    if (alive[tree.right[node]] > 0) stack.push_back({tree.right[node], id, false});
    if (alive[node + 1] > 0) stack.push_back({node + 1, id, false});
    if (number[node] != scene::kNone) stack.push_back({node, id, true});
  }
}

/// Whether cells draw no better than the one GPU-instancing node that the file has already.
bool is_as_before(const scene::Scene& scene, const Placements& placements,
                  std::span<const InstancePart> parts, std::span<const InstanceCell> cells) {
  const scene::Object& first = scene.objects[placements.front().front()];
  if (first.instance == scene::kNone || cells.size() != placements.front().size()) return false;
  for (const InstancePart& part : parts)
    if (!part.whole) return false;
  for (const auto& objects : placements)
    if (scene.objects[objects.front()].node != first.node) return false;
  return true;
}

}  // namespace

double expected_inside_draws(const std::vector<DrawItem>& draws, const ViewDistribution& views) {
  std::vector<double> chance(draws.size());
  parallel_for(draws.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) chance[i] = views.chance(draws[i].box).inside;
  });
  return std::accumulate(chance.begin(), chance.end(), 0.0);
}

Problem::Problem(const Subject& s, Fates fates)
    : subject_(s),
      fates_(std::move(fates)),
      is_merged_(merged_triangles(s.scene, fates_)),
      cuts_(s.scene, s.tree, is_merged_, s.keys, s.max_vertices, s.views) {
  for (const Placements& placements : fates_.shared)
    instanced_.emplace_back(s.scene, s.keys, placements, s.views, s.prices);
  std::vector<std::uint32_t> left;
  for (std::uint32_t o = 0; o < s.scene.objects.size(); ++o)
    if (fates_.of_object[o] == Fate::kLeft) left.push_back(o);
  left_inside_draws_ = expected_inside_draws(draws_of_objects(s.scene, left), s.views);
}

Frame Problem::solve(const Prices& prices) const {
  Frame frame = cuts_.solve_within(prices, subject_.options.max_batches).frame;
  for (const InstanceCuts& cuts : instanced_) frame += cuts.solve(prices);
  return frame;
}

Prices Problem::least_prices(double limit) const {
  Prices prices = subject_.prices;
  const auto fits = [&](double draw) {
    const Frame frame = solve({draw, prices.vertex, prices.triangle});
    return frame.inside_draws + left_inside_draws_ <= limit;
  };
  constexpr double kClose = 1.02, kStep = 4, kCheapestDraw = 1e-3;
  double low = std::max(prices.draw, kCheapestDraw), high = low;
  if (fits(high)) {
    while (low > kCheapestDraw && fits(low)) {
      high = low;
      low /= kStep;
    }
  } else {
    do {
      low = high;
      high *= kStep;
    } while (high < kDearestDraw && !fits(high));
  }
  while (high > kClose * low) {
    const double middle = std::sqrt(low * high);
    (fits(middle) ? high : low) = middle;
  }
  prices.draw = high;
  return prices;
}

double Problem::fewest_inside_draws() const {
  const Prices& prices = subject_.prices;
  return solve({kDearestDraw, prices.vertex, prices.triangle}).inside_draws + left_inside_draws_;
}

void Problem::fill(const Prices& prices, BatchPlan& result) const {
  const Subject& s = subject_;
  result.draw_price = prices.draw;
  result.geometry_bytes = fates_.geometry_bytes;
  result.copied_bytes = fates_.copied_bytes;
  std::vector<Fate> fate = fates_.of_object;
  for (std::size_t m = 0; m < instanced_.size(); ++m) {
    const std::size_t first_part = result.parts.size(), first_cell = result.cells.size();
    instanced_[m].take(s.scene, s.keys, prices, result.parts, result.cells);
    if (!is_as_before(s.scene, fates_.shared[m], std::span(result.parts).subspan(first_part),
                      std::span(result.cells).subspan(first_cell)))
      continue;
    result.parts.resize(first_part);
    result.cells.resize(first_cell);
    for (const auto& objects : fates_.shared[m])
      for (const std::uint32_t o : objects) fate[o] = Fate::kLeft;
  }
  const auto solution = cuts_.solve_within(prices, s.options.max_batches);
  std::vector<std::uint32_t> node_of =
      cuts_.nodes_of_triangles(solution, s.tree, s.keys, is_merged_);
  result.split_objects =
      keep_objects_whole(s.scene, s.keys, prices, s.max_vertices, s.views, node_of);
  leave_whole_blended(s.scene, node_of, fate);
  std::vector<std::uint32_t> number;
  fill_batches(s.scene, s.keys, node_of, cuts_, number, result);
  fill_tree(cuts_, number, result);
  for (std::uint32_t o = 0; o < s.scene.objects.size(); ++o)
    if (fate[o] == Fate::kLeft)
      result.left_alone.push_back(
          {o, fates_.of_object[o] == Fate::kMerged ? kBlendedReason : fates_.reason[o]});
  const Frame frame = solve(prices);
  result.expected_draws = frame.draws;
  result.expected_triangles = frame.triangles;
}

}  // namespace lightbatch::batches
