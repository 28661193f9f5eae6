// Batches from one hierarchy: geometry that is seen together is drawn together (Mueller, Schaefer,
// Fellner: Automatic creation of object hierarchies for radiosity, 1999, section on rendering).
// There the depth was chosen by hand; here it is the cut of least expected cost of a frame.
#include "core/batches/plan.h"

#include <algorithm>
#include <set>

#include "core/batches/assignment.h"
#include "core/batches/coarse_tree.h"
#include "core/batches/cut.h"
#include "core/batches/views.h"

namespace lightbatch::batches {
namespace {

Status check(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
             const BatchOptions& options) {
  LB_CHECK(tree.primitive_count() == scene.triangles.size(), "the hierarchy is not of this scene");
  LB_CHECK(options.traits.empty() || options.traits.size() == scene.objects.size(),
           "one traits entry for each object");
  LB_CHECK(
      options.page_of_triangle.empty() || options.page_of_triangle.size() == scene.triangles.size(),
      "one page for each triangle");
  if (!(options.max_growth >= 1)) return bad_option("max_growth must be at least 1");
  if (options.max_vertices != 0 && options.max_vertices < 3)
    return bad_option("max_vertices must be 0 or at least 3");
  return {};
}

/// Draw calls that the input needs: GPU instances of one node and primitive are one.
std::uint64_t draws_of_objects(const scene::Scene& scene, const std::vector<std::uint32_t>& which) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> groups;
  std::uint64_t draws = 0;
  for (const std::uint32_t o : which) {
    const scene::Object& object = scene.objects[o];
    if (object.instance == scene::kNone || groups.insert({object.node, object.primitive}).second)
      ++draws;
  }
  return draws;
}

void add_curve(const CoarseTree& coarse, BatchPlan& result) {
  constexpr double kLow = 4, kHigh = 3e6, kStep = 2;
  std::vector<double> cost(coarse.size());
  for (double worth = kHigh; worth >= kLow; worth /= kStep) {
    for (std::uint32_t i = 0; i < coarse.size(); ++i)
      cost[i] = coarse.cost[i].triangles + worth * coarse.cost[i].draws;
    const Cut cut = best_cut(coarse.tree, cost, 0);
    CurvePoint point;
    point.draw_cost = worth;
    point.batches = static_cast<std::uint32_t>(cut.nodes.size());
    for (const std::uint32_t i : cut.nodes) {
      point.draws += coarse.cost[i].draws;
      point.triangles += coarse.cost[i].triangles;
    }
    if (result.curve.empty() || result.curve.back().batches != point.batches)
      result.curve.push_back(point);
  }
}

/// Batches from the batch of each triangle; `number` maps cut positions to batches, kNone when
/// nothing was left there.
void fill_batches(const scene::Scene& scene, const KeyMap& keys,
                  const std::vector<std::uint32_t>& batch_of, const CoarseTree& coarse,
                  const Cut& cut, std::vector<std::uint32_t>& number, BatchPlan& result) {
  struct Slot {
    std::uint32_t key;
    Group group;
  };
  std::vector<std::vector<Slot>> slots(cut.nodes.size());
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
    const std::uint32_t b = batch_of[t];
    if (b == scene::kNone) continue;
    const std::uint32_t key = keys.of_triangle[t];
    const std::uint32_t object = scene.triangles[t].object;
    auto it = std::lower_bound(slots[b].begin(), slots[b].end(), key,
                               [](const Slot& s, std::uint32_t k) { return s.key < k; });
    if (it == slots[b].end() || it->key != key) {
      it = slots[b].insert(it, Slot{key, {}});
      it->group.material = keys.keys[key].material;
      it->group.layout = keys.keys[key].layout;
      it->group.page = keys.keys[key].page;
    }
    Group& group = it->group;
    if (group.pieces.empty() || group.pieces.back().object != object)
      group.pieces.push_back({object, {}});
    auto& ranges = group.pieces.back().ranges;
    if (!ranges.empty() && ranges.back().first + ranges.back().count == t)
      ++ranges.back().count;
    else
      ranges.push_back({t, 1});
    group.triangles += 1;
    group.vertices += keys.vertices_of_object[object];
    for (const Vec3f& p : scene.corners(t)) group.box.add(p);
  }
  number.assign(cut.nodes.size(), scene::kNone);
  for (std::size_t b = 0; b < slots.size(); ++b) {
    if (slots[b].empty()) continue;
    number[b] = static_cast<std::uint32_t>(result.batches.size());
    Batch batch;
    batch.node = coarse.node[cut.nodes[b]];
    for (Slot& slot : slots[b]) {
      batch.box.add(slot.group.box);
      batch.groups.push_back(std::move(slot.group));
    }
    result.batches.push_back(std::move(batch));
  }
}

/// The coarse tree above the cut, without empty batches and without nodes that have one child.
void fill_tree(const CoarseTree& coarse, const Cut& cut, const std::vector<std::uint32_t>& number,
               BatchPlan& result) {
  if (coarse.size() == 0) return;
  std::vector<std::uint32_t> at(coarse.size(), scene::kNone);  // position in the cut
  std::vector<bool> cut_here(coarse.size(), false);
  for (std::uint32_t k = 0; k < cut.nodes.size(); ++k) {
    at[cut.nodes[k]] = number[k];
    cut_here[cut.nodes[k]] = true;
  }
  std::vector<std::uint32_t> alive(coarse.size(), 0);  // batches at or under the node
  std::vector<bool> above(coarse.size(), false);
  std::vector<std::uint32_t> stack{0}, order;
  while (!stack.empty()) {
    const std::uint32_t i = stack.back();
    stack.pop_back();
    order.push_back(i);
    if (cut_here[i]) continue;
    above[i] = true;
    stack.push_back(coarse.tree.right[i]);
    stack.push_back(i + 1);
  }
  for (auto it = order.rbegin(); it != order.rend(); ++it)
    alive[*it] = above[*it] ? alive[*it + 1] + alive[coarse.tree.right[*it]]
                            : (at[*it] == scene::kNone ? 0u : 1u);
  if (alive[0] == 0) return;
  struct Entry {
    std::uint32_t node, parent;
    bool right;
  };
  std::vector<Entry> todo{{0, scene::kNone, false}};
  while (!todo.empty()) {
    auto [node, parent, right] = todo.back();
    todo.pop_back();
    while (above[node]) {
      const std::uint32_t l = node + 1, r = coarse.tree.right[node];
      if (alive[l] == 0)
        node = r;
      else if (alive[r] == 0)
        node = l;
      else
        break;
    }
    const auto id = static_cast<std::uint32_t>(result.tree.size());
    if (parent != scene::kNone) (right ? result.tree[parent].right : result.tree[parent].left) = id;
    result.tree.emplace_back();
    if (!above[node]) {
      result.tree.back().batch = at[node];
      continue;
    }
    todo.push_back({coarse.tree.right[node], id, true});
    todo.push_back({node + 1, id, false});
  }
}

}  // namespace

Result<BatchPlan> plan(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
                       const Profile& profile, const BatchOptions& options,
                       const Progress& progress) {
  LB_RETURN_IF_ERROR(check(scene, tree, options));
  BatchPlan result;
  result.max_vertices = options.max_vertices != 0 ? options.max_vertices : profile.max_vertices;
  progress.report("batches", 0);

  const ViewDistribution views(scene, profile);
  const KeyMap keys = map_keys(scene, options);
  Fates fates = decide_fates(scene, profile, options, views, keys);
  if (progress.cancelled()) return cancelled();
  progress.report("batches", 0.3);
  std::vector<bool> merged(scene.triangles.size());
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t)
    merged[t] = fates.of_object[scene.triangles[t].object] == Fate::kMerged;
  const CoarseTree coarse =
      make_coarse_tree(scene, tree, merged, keys, profile, result.max_vertices, views);
  if (progress.cancelled()) return cancelled();
  progress.report("batches", 0.7);

  std::vector<double> cost(coarse.size());
  for (std::uint32_t i = 0; i < coarse.size(); ++i) cost[i] = coarse.cost[i].cost;
  const Cut cut = best_cut_within(coarse.tree, cost, options.max_batches);
  for (const std::uint32_t i : cut.nodes) {
    result.expected_draws += coarse.cost[i].draws;
    result.expected_triangles += coarse.cost[i].triangles;
  }
  add_curve(coarse, result);

  std::vector<std::uint32_t> batch_of(scene.triangles.size(), scene::kNone);
  for (std::uint32_t k = 0; k < cut.nodes.size(); ++k)
    for (const std::uint32_t t : tree.primitives(coarse.node[cut.nodes[k]]))
      if (merged[t]) batch_of[t] = k;
  result.split_objects =
      keep_objects_whole(scene, keys, profile, result.max_vertices, views, batch_of);
  if (progress.cancelled()) return cancelled();
  std::vector<std::uint32_t> number;
  fill_batches(scene, keys, batch_of, coarse, cut, number, result);
  fill_tree(coarse, cut, number, result);

  result.cells = std::move(fates.cells);
  result.geometry_bytes = fates.geometry_bytes;
  result.copied_bytes = fates.copied_bytes;
  std::vector<std::uint32_t> all(scene.objects.size()), left;
  for (std::uint32_t o = 0; o < scene.objects.size(); ++o) {
    all[o] = o;
    if (fates.of_object[o] != Fate::kLeft) continue;
    left.push_back(o);
    result.left_alone.push_back({o, std::move(fates.reason[o])});
  }
  result.draws_before = draws_of_objects(scene, all);
  result.draws_after = draws_of_objects(scene, left);
  for (const Batch& batch : result.batches) result.draws_after += batch.groups.size();
  for (const InstanceCell& cell : result.cells) result.draws_after += cell.primitives.size();
  progress.report("batches", 1);
  return result;
}

}  // namespace lightbatch::batches
