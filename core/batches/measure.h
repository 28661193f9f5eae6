#pragma once

#include <cstdint>
#include <vector>

#include "core/batches/plan.h"
#include "core/batches/profile.h"
#include "core/batches/views.h"

namespace lightbatch::batches {

/// One thing that a viewer culls and draws by itself.
struct DrawItem {
  Aabb box;
  std::uint64_t triangles = 0;
};

/// The file as it came: each primitive under each node; GPU instances of one node together.
std::vector<DrawItem> draws_of_input(const scene::Scene& scene);
/// The same for some objects.
std::vector<DrawItem> draws_of_objects(const scene::Scene& scene,
                                       const std::vector<std::uint32_t>& objects);
/// The file as it goes: groups of batches, instance cells, and what was left alone.
std::vector<DrawItem> draws_of_plan(const scene::Scene& scene, const BatchPlan& plan);
/// What is compared against: everything joined by material, then split at the median centroid of
/// the longest axis into leaves of at most `leaf` triangles.
std::vector<DrawItem> draws_of_median_split(const scene::Scene& scene, std::uint32_t leaf);

struct ViewFigures {
  double draws = 0;      // mean of a view
  double triangles = 0;  // submitted, mean of a view
  double cost = 0;       // us by the profile, vertices left out
};
/// Inside: views from where people stand; outside: looking in.
struct ViewsFigures {
  ViewFigures inside, outside;
};

struct ViewsReport {
  std::uint32_t inside_views = 0, outside_views = 0;
  double ideal_inside = 0, ideal_outside = 0;  // triangles not wholly outside one frustum plane
  ViewsFigures before, after;
};

/// The views that measures are means of, by weight.
struct ViewSet {
  ViewSet() = default;
  ViewSet(const Profile& profile, std::vector<View> views);
  /// Of the mean over the views inside, or over those outside.
  double share(const View& view) const {
    return view.weight / (view.inside ? inside_weight : outside_weight);
  }

  Profile profile;
  std::vector<View> views;
  std::uint32_t inside = 0, outside = 0;
  double inside_weight = 0, outside_weight = 0;
  double ideal_inside = 0, ideal_outside = 0;  // triangles not wholly outside one frustum plane
};
/// 256 views inside and 16 outside, fixed for a scene and profile, or the caller's cameras.
ViewSet make_view_set(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
                      const Viewpoints& viewpoints);
/// Means over the views (frustum culling of boxes).
ViewsFigures measure_draws(const ViewSet& views, const std::vector<DrawItem>& draws);
/// Input and plan against the ideal culler of single triangles.
ViewsReport measure_views(const scene::Scene& scene, const ViewSet& set, const BatchPlan& plan);

}  // namespace lightbatch::batches
