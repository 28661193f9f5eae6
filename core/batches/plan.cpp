// Batches from one hierarchy: geometry that is seen together is drawn together (Mueller, Schaefer,
// Fellner: Automatic creation of object hierarchies for radiosity, 1999, section on rendering).
// There the depth was chosen by hand; here it is the cut of least expected cost of a frame.
#include "core/batches/plan.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "core/batches/assignment.h"
#include "core/batches/measure.h"
#include "core/batches/problem.h"
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

/// What a file of many draws is brought to, in a mean view from inside.
class Goal {
 public:
  Goal(const ViewSet& views, const std::vector<DrawItem>& before, double draws_share)
      : views_(views),
        draws_(draws_share * measure_draws(views, before).inside.draws),
        triangles_(kTrianglesOfIdeal * views.ideal_inside) {}

  struct Distance {
    double draws = 0, triangles = 0;  // as shares of what is allowed
    bool met() const { return draws <= 1 && triangles <= 1; }
    /// Draws come first: their share is the caller's.
    bool operator<(const Distance& other) const {
      const double d = std::max(draws, 1.0), e = std::max(other.draws, 1.0);
      return d != e ? d < e : triangles < other.triangles;
    }
  };
  Distance distance(const scene::Scene& scene, const BatchPlan& plan) const {
    const ViewFigures inside = measure_draws(views_, draws_of_plan(scene, plan)).inside;
    return {draws_ > 0 ? inside.draws / draws_ : 1,
            triangles_ > 0 ? inside.triangles / triangles_ : 1};
  }

 private:
  static constexpr double kTrianglesOfIdeal = 2;
  const ViewSet& views_;
  double draws_ = 0, triangles_ = 0;
};

struct Attempt {
  BatchPlan plan;
  Goal::Distance distance;
};

/// The plan of one problem that comes nearest to the goal, at the price of a draw that is nearest
/// to the profile's. limit: of the model's draws from inside, before it is corrected.
Attempt approach(const Subject& subject, const Problem& problem, const BatchPlan& empty,
                 const Goal& goal, double limit) {
  const auto attempt_at = [&](double draw_price) {
    Attempt attempt{empty, {}};
    problem.fill({draw_price, subject.prices.vertex, subject.prices.triangle}, attempt.plan);
    attempt.distance = goal.distance(subject.scene, attempt.plan);
    return attempt;
  };
  Attempt best = attempt_at(subject.prices.draw);
  if (best.distance.met()) return best;
  // The model takes the chances of large boxes for a little less than they are.
  constexpr int kTries = 4;
  constexpr double kLeastStep = 0.99;
  for (int i = 0; i < kTries; ++i) {
    Attempt attempt = attempt_at(problem.least_prices(limit).draw);
    const double draws = attempt.distance.draws;
    if (attempt.distance < best.distance) best = std::move(attempt);
    if (draws <= 1 || best.plan.draw_price >= kDearestDraw) break;
    limit *= std::min(1 / draws, kLeastStep);
  }
  // Few draws and many triangles at the profile's price: no cheaper draws than it takes.
  constexpr double kNear = 1.2;
  double high = subject.prices.draw;
  while (best.distance.met() && best.plan.draw_price * kNear < high) {
    const double middle = std::sqrt(best.plan.draw_price * high);
    Attempt attempt = attempt_at(middle);
    if (attempt.distance.met())
      best = std::move(attempt);
    else
      high = middle;
  }
  return best;
}

/// Copies may add this much before it is known that a file of many draws needs more. With lightmaps
/// every placement has bytes of its own anyway.
CopyLimits first_limits(const BatchOptions& options) {
  const bool lit = !options.page_of_triangle.empty();
  return {lit ? options.max_growth : std::min(options.max_growth, 1 + kLittleGrowth), 0};
}

/// No more copies than the goal needs: halves the way between what met it and what may not have.
void save_copies(const Subject& subject, const BatchPlan& empty, const Goal& goal, double limit,
                 double bytes_of_draw, std::unique_ptr<Problem>& problem, Attempt& best) {
  constexpr int kTries = 2;
  constexpr double kMostSaved = 4;
  const auto growth_of = [](const Problem& p) {
    return 1 + p.fates().copied_bytes / std::max(p.fates().geometry_bytes, 1.0);
  };
  double low = std::max(1 + kLittleGrowth, growth_of(*problem) / kMostSaved);
  for (int i = 0; i < kTries; ++i) {
    const double high = growth_of(*problem);
    if (low >= high) return;
    const double middle = std::sqrt(low * high);
    auto fewer = std::make_unique<Problem>(
        subject,
        decide_fates(subject.scene, subject.options, subject.keys, {middle, bytes_of_draw}));
    Attempt attempt = approach(subject, *fewer, empty, goal, limit);
    if (attempt.distance.met()) {
      best = std::move(attempt);
      problem = std::move(fewer);
    } else {
      low = middle;
    }
  }
}

void add_curve(const Problem& problem, BatchPlan& result) {
  constexpr double kLow = 4, kHigh = 3e6, kStep = 2;
  for (double worth = kHigh; worth >= kLow; worth /= kStep) {
    const Frame frame = problem.solve({worth, 0, 1});
    CurvePoint point;
    point.draw_cost = worth;
    point.batches = problem.merged().solve({worth, 0, 1}).batches;
    point.draws = frame.draws;
    point.triangles = frame.triangles;
    if (result.curve.empty() || result.curve.back().draws != point.draws)
      result.curve.push_back(point);
  }
}

}  // namespace

Result<BatchPlan> plan(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
                       const Viewpoints& viewpoints, const BatchOptions& options,
                       const Progress& progress, const ViewSet* measured) {
  const Profile& profile = viewpoints.profile();
  LB_RETURN_IF_ERROR(check(scene, tree, options));
  progress.report("batches", 0);

  const ViewDistribution views(viewpoints);
  const KeyMap keys = map_keys(scene, options);
  const std::uint32_t max_vertices =
      options.max_vertices != 0 ? options.max_vertices : profile.max_vertices;
  const Subject subject{scene, tree, options, keys, views, prices_of(profile), max_vertices};
  const std::vector<DrawItem> before = draws_of_input(scene);
  BatchPlan empty;
  empty.max_vertices = max_vertices;
  empty.draws_before = before.size();

  CopyLimits limits = first_limits(options);
  auto problem = std::make_unique<Problem>(subject, decide_fates(scene, options, keys, limits));
  if (progress.cancelled()) return cancelled();
  progress.report("batches", 0.6);
  BatchPlan result = empty;
  if (options.draws_share < 1 && before.size() > options.free_draws) {
    std::optional<ViewSet> made;
    if (measured == nullptr) measured = &made.emplace(make_view_set(scene, tree, viewpoints));
    const Goal goal(*measured, before, options.draws_share);
    const double limit = options.draws_share * expected_inside_draws(before, views);
    if (limits.growth < options.max_growth && problem->fewest_inside_draws() > limit) {
      limits.growth = options.max_growth;
      problem = std::make_unique<Problem>(subject, decide_fates(scene, options, keys, limits));
    }
    Attempt best = approach(subject, *problem, empty, goal, limit);
    // What instances cannot reach, more copies may.
    while (!best.distance.met()) {
      if (progress.cancelled()) return cancelled();
      const bool all_growth = limits.growth >= options.max_growth;
      limits = {options.max_growth, all_growth ? problem->fates().next_bytes_of_draw : 0.0};
      Fates fates = decide_fates(scene, options, keys, limits);
      if (!(fates.copied_bytes > problem->fates().copied_bytes)) {
        if (all_growth) break;
        continue;
      }
      auto copied = std::make_unique<Problem>(subject, std::move(fates));
      Attempt attempt = approach(subject, *copied, empty, goal, limit);
      if (!(attempt.distance < best.distance)) break;
      best = std::move(attempt);
      problem = std::move(copied);
    }
    const bool lit = !options.page_of_triangle.empty();
    if (!lit && best.distance.met())
      save_copies(subject, empty, goal, limit, limits.bytes_of_draw, problem, best);
    result = std::move(best.plan);
  } else {
    problem->fill(subject.prices, result);
  }
  add_curve(*problem, result);
  result.draws_after = draws_of_plan(scene, result).size();
  progress.report("batches", 1);
  return result;
}

}  // namespace lightbatch::batches
