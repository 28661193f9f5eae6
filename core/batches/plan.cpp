// Batches from one hierarchy: geometry that is seen together is drawn together (Mueller, Schaefer,
// Fellner: Automatic creation of object hierarchies for radiosity, 1999, section on rendering).
// There the depth was chosen by hand; here it is the cut of least expected cost of a frame.
#include "core/batches/plan.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "core/base/parallel.h"
#include "core/batches/assignment.h"
#include "core/batches/fates.h"
#include "core/batches/instance_cuts.h"
#include "core/batches/key_cuts.h"
#include "core/batches/measure.h"
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
  if (!(options.draws_share > 0)) return bad_option("the share of draws must be above 0");
  if (!(options.max_growth >= 1)) return bad_option("max_growth must be at least 1");
  if (options.max_vertices != 0 && options.max_vertices < 3)
    return bad_option("max_vertices must be 0 or at least 3");
  return {};
}

/// Draws of a view from inside, by the model.
double expected_inside_draws(const std::vector<DrawItem>& draws, const ViewDistribution& views) {
  std::vector<double> chance(draws.size());
  parallel_for(draws.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) chance[i] = views.chance(draws[i].box).inside;
  });
  return std::accumulate(chance.begin(), chance.end(), 0.0);
}

/// Draws of a mean view from inside, counted.
double sampled_inside_draws(const Viewpoints& viewpoints, const std::vector<DrawItem>& draws) {
  constexpr std::uint32_t kViews = 256;
  const ViewSet set(viewpoints.profile(), viewpoints.sample(kViews, 0, kPlanningViews));
  return measure_draws(set, draws).inside.draws;
}

/// All that is cut.
struct Problem {
  const KeyCuts& merged;
  const std::vector<InstanceCuts>& instanced;
  std::uint32_t max_batches = 0;
  double left_inside_draws = 0;

  Frame solve(const Prices& prices) const {
    Frame frame = merged.solve_within(prices, max_batches).frame;
    for (const InstanceCuts& cuts : instanced) frame += cuts.solve(prices);
    return frame;
  }
};

/// us; at this price nothing is split any more.
constexpr double kDearestDraw = 1e7;

/// The least price of a draw, from the profile's up, at which views from inside draw at most
/// `limit` times. When nothing reaches it, the price at which nothing changes any more.
Prices prices_within(const Problem& problem, Prices prices, double limit) {
  const auto fits = [&](double draw) {
    const Frame frame = problem.solve({draw, prices.vertex, prices.triangle});
    return frame.inside_draws + problem.left_inside_draws <= limit;
  };
  if (fits(prices.draw)) return prices;
  constexpr double kClose = 1.02;
  double low = prices.draw, high = std::max(prices.draw, 1e-3);
  do {
    low = high;
    high *= 4;
  } while (high < kDearestDraw && !fits(high));
  while (high > kClose * low) {
    const double middle = std::sqrt(low * high);
    (fits(middle) ? high : low) = middle;
  }
  prices.draw = high;
  return prices;
}

void add_curve(const Problem& problem, BatchPlan& result) {
  constexpr double kLow = 4, kHigh = 3e6, kStep = 2;
  for (double worth = kHigh; worth >= kLow; worth /= kStep) {
    CurvePoint point;
    point.draw_cost = worth;
    const auto solution = problem.merged.solve({worth, 0, 1});
    Frame frame = solution.frame;
    for (const InstanceCuts& cuts : problem.instanced) frame += cuts.solve({worth, 0, 1});
    point.batches = solution.batches;
    point.draws = frame.draws;
    point.triangles = frame.triangles;
    if (result.curve.empty() || result.curve.back().draws != point.draws)
      result.curve.push_back(point);
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
  std::vector<Entry> todo{{0, scene::kNone, false}};
  while (!todo.empty()) {
    auto [node, parent, batch] = todo.back();
    todo.pop_back();
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
    if (alive[tree.right[node]] > 0) todo.push_back({tree.right[node], id, false});
    if (alive[node + 1] > 0) todo.push_back({node + 1, id, false});
    if (number[node] != scene::kNone) todo.push_back({node, id, true});
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

/// What a plan is made from, whatever the prices.
struct Subject {
  const scene::Scene& scene;
  const hierarchy::Hierarchy& tree;
  const KeyMap& keys;
  const ViewDistribution& views;
  const Fates& fates;
  const std::vector<bool>& merged;  // by triangle
  const Problem& problem;
};

/// The batches and cells that are cheapest at these prices; the rest is left alone.
void fill_plan(const Subject& s, const Prices& prices, BatchPlan& result) {
  std::vector<Fate> fate = s.fates.of_object;
  for (std::size_t m = 0; m < s.problem.instanced.size(); ++m) {
    const std::size_t first_part = result.parts.size(), first_cell = result.cells.size();
    s.problem.instanced[m].take(s.scene, s.keys, prices, result.parts, result.cells);
    if (!is_as_before(s.scene, s.fates.shared[m], std::span(result.parts).subspan(first_part),
                      std::span(result.cells).subspan(first_cell)))
      continue;
    result.parts.resize(first_part);
    result.cells.resize(first_cell);
    for (const auto& objects : s.fates.shared[m])
      for (const std::uint32_t o : objects) fate[o] = Fate::kLeft;
  }
  const KeyCuts& cuts = s.problem.merged;
  const auto solution = cuts.solve_within(prices, s.problem.max_batches);
  std::vector<std::uint32_t> node_of = cuts.nodes_of_triangles(solution, s.tree, s.keys, s.merged);
  result.split_objects =
      keep_objects_whole(s.scene, s.keys, prices, result.max_vertices, s.views, node_of);
  std::vector<std::uint32_t> number;
  fill_batches(s.scene, s.keys, node_of, cuts, number, result);
  fill_tree(cuts, number, result);
  for (std::uint32_t o = 0; o < s.scene.objects.size(); ++o)
    if (fate[o] == Fate::kLeft) result.left_alone.push_back({o, s.fates.reason[o]});
}

}  // namespace

Result<BatchPlan> plan(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
                       const Viewpoints& viewpoints, const BatchOptions& options,
                       const Progress& progress) {
  const Profile& profile = viewpoints.profile();
  LB_RETURN_IF_ERROR(check(scene, tree, options));
  BatchPlan result;
  result.max_vertices = options.max_vertices != 0 ? options.max_vertices : profile.max_vertices;
  progress.report("batches", 0);

  const ViewDistribution views(viewpoints);
  const KeyMap keys = map_keys(scene, options);
  const Fates fates = decide_fates(scene, options, keys);
  std::vector<bool> merged(scene.triangles.size());
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t)
    merged[t] = fates.of_object[scene.triangles[t].object] == Fate::kMerged;
  if (progress.cancelled()) return cancelled();
  progress.report("batches", 0.1);
  const KeyCuts cuts(scene, tree, merged, keys, result.max_vertices, views);
  if (progress.cancelled()) return cancelled();
  progress.report("batches", 0.4);
  Prices prices = prices_of(profile);
  std::vector<InstanceCuts> instanced;
  for (const Placements& placements : fates.shared) {
    instanced.emplace_back(scene, keys, placements, views, prices);
    if (progress.cancelled()) return cancelled();
  }
  progress.report("batches", 0.7);

  Problem problem{cuts, instanced, options.max_batches, 0};
  const Subject subject{scene, tree, keys, views, fates, merged, problem};
  const std::vector<DrawItem> before = draws_of_input(scene);
  result.draws_before = before.size();
  result.geometry_bytes = fates.geometry_bytes;
  result.copied_bytes = fates.copied_bytes;
  const bool limited = options.draws_share < 1 && result.draws_before > options.free_draws;
  if (limited) {
    std::vector<std::uint32_t> left;
    for (std::uint32_t o = 0; o < scene.objects.size(); ++o)
      if (fates.of_object[o] == Fate::kLeft) left.push_back(o);
    problem.left_inside_draws = expected_inside_draws(draws_of_objects(scene, left), views);
  }
  // The model takes the chances of large boxes for a little less than they are: its limit is
  // corrected by what sampled views draw.
  constexpr int kTries = 3;
  const BatchPlan empty = result;
  double limit = options.draws_share * expected_inside_draws(before, views);
  const double wanted =
      limited ? options.draws_share * sampled_inside_draws(viewpoints, before) : 0;
  for (int attempt = 1;; ++attempt) {
    if (progress.cancelled()) return cancelled();
    const Prices chosen = limited ? prices_within(problem, prices, limit) : prices;
    result = empty;
    result.draw_price = chosen.draw;
    fill_plan(subject, chosen, result);
    if (!limited || attempt == kTries) break;
    const double drawn = sampled_inside_draws(viewpoints, draws_of_plan(scene, result));
    if (drawn <= wanted || chosen.draw >= kDearestDraw) break;
    limit *= wanted / drawn;
  }
  const Frame frame = problem.solve({result.draw_price, prices.vertex, prices.triangle});
  result.expected_draws = frame.draws;
  result.expected_triangles = frame.triangles;
  add_curve(problem, result);
  result.draws_after = draws_of_plan(scene, result).size();
  progress.report("batches", 1);
  return result;
}

}  // namespace lightbatch::batches
