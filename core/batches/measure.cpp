#include "core/batches/measure.h"

#include <algorithm>
#include <map>

#include "core/base/parallel.h"
#include "core/batches/views.h"

namespace lightbatch::batches {
namespace {

constexpr std::uint32_t kInsideViews = 256;
constexpr std::uint32_t kOutsideViews = 16;

Aabb triangle_box(const scene::Scene& scene, std::uint32_t triangle) {
  Aabb box;
  for (const Vec3f& p : scene.corners(triangle)) box.add(p);
  return box;
}

/// Adds objects one by one; those drawn by one call share an item.
class ObjectDraws {
 public:
  explicit ObjectDraws(const scene::Scene& scene) : scene_(scene) {}
  void add(std::uint32_t index) {
    const scene::Object& object = scene_.objects[index];
    if (object.triangle_count == 0) return;
    std::size_t item = items.size();
    if (object.instance != scene::kNone)
      item = shared_.try_emplace({object.node, object.primitive}, item).first->second;
    if (item == items.size()) items.emplace_back();
    items[item].triangles += object.triangle_count;
    for (std::uint32_t k = 0; k < object.triangle_count; ++k)
      items[item].box.add(triangle_box(scene_, object.first_triangle + k));
  }
  std::vector<DrawItem> items;

 private:
  const scene::Scene& scene_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> shared_;
};

std::uint64_t ideal_triangles(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
                              const Frustum& frustum) {
  std::uint64_t count = 0;
  // Nodes and the planes that they are not wholly inside of.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> stack;
  if (!tree.is_empty()) stack.emplace_back(0, Frustum::kAllPlanes);
  while (!stack.empty()) {
    auto [node, planes] = stack.back();
    stack.pop_back();
    if (frustum.outside(tree.box(node), planes)) continue;
    if (planes == 0) {
      count += tree.count(node);
    } else if (tree.is_leaf(node)) {
      const auto c = scene.corners(tree.primitive(tree.first(node)));
      if (!frustum.outside(to_double(c[0]), to_double(c[1]), to_double(c[2]))) ++count;
    } else {
      stack.emplace_back(tree.right(node), planes);
      stack.emplace_back(tree.left(node), planes);
    }
  }
  return count;
}

}  // namespace

std::vector<DrawItem> draws_of_input(const scene::Scene& scene) {
  ObjectDraws draws(scene);
  for (std::uint32_t o = 0; o < scene.objects.size(); ++o) draws.add(o);
  return std::move(draws.items);
}

std::vector<DrawItem> draws_of_objects(const scene::Scene& scene,
                                       const std::vector<std::uint32_t>& objects) {
  ObjectDraws draws(scene);
  for (const std::uint32_t o : objects) draws.add(o);
  return std::move(draws.items);
}

std::vector<DrawItem> draws_of_plan(const scene::Scene& scene, const BatchPlan& plan) {
  ObjectDraws left(scene);
  for (const LeftAlone& alone : plan.left_alone) left.add(alone.object);
  std::vector<DrawItem> draws = std::move(left.items);
  for (const Batch& batch : plan.batches)
    for (const Group& group : batch.groups) draws.push_back({group.box, group.triangles});
  for (const InstanceCell& cell : plan.cells) draws.push_back({cell.box, cell.triangles});
  return draws;
}

std::vector<DrawItem> draws_of_median_split(const scene::Scene& scene, std::uint32_t leaf) {
  std::vector<std::uint32_t> order(scene.triangles.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::vector<DrawItem> draws;
  std::vector<std::pair<std::size_t, std::size_t>> stack;
  if (!order.empty()) stack.emplace_back(0, order.size());
  const auto centroid = [&](std::uint32_t t, std::size_t axis) {
    const auto c = scene.corners(t);
    return c[0][axis] + c[1][axis] + c[2][axis];
  };
  while (!stack.empty()) {
    const auto [begin, end] = stack.back();
    stack.pop_back();
    if (end - begin <= leaf) {
      std::map<std::uint32_t, DrawItem> by_material;
      for (std::size_t i = begin; i < end; ++i) {
        DrawItem& item = by_material[scene.objects[scene.triangles[order[i]].object].material];
        item.triangles += 1;
        item.box.add(triangle_box(scene, order[i]));
      }
      for (auto& [material, item] : by_material) draws.push_back(item);
      continue;
    }
    Aabb box;
    for (std::size_t i = begin; i < end; ++i) box.add(triangle_box(scene, order[i]));
    const Vec3f e = box.extent();
    const std::size_t axis = e.x >= e.y && e.x >= e.z ? 0 : e.y >= e.z ? 1 : 2;
    const std::size_t middle = begin + (end - begin) / 2;
    std::nth_element(order.begin() + static_cast<std::ptrdiff_t>(begin),
                     order.begin() + static_cast<std::ptrdiff_t>(middle),
                     order.begin() + static_cast<std::ptrdiff_t>(end),
                     [&](std::uint32_t a, std::uint32_t b) {
                       const float ca = centroid(a, axis), cb = centroid(b, axis);
                       return ca != cb ? ca < cb : a < b;
                     });
    stack.emplace_back(middle, end);
    stack.emplace_back(begin, middle);
  }
  return draws;
}

ViewsFigures measure_draws(const ViewSet& set, const std::vector<DrawItem>& draws) {
  const Profile& profile = set.profile;
  std::vector<ViewFigures> per_view(set.views.size());
  parallel_for(set.views.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const Frustum frustum(set.views[v], profile);
      for (const DrawItem& item : draws) {
        if (frustum.outside(item.box)) continue;
        const double triangles = static_cast<double>(item.triangles);
        per_view[v].draws += 1;
        per_view[v].triangles += triangles;
        per_view[v].cost += profile.draw + profile.state + triangles * profile.triangle;
      }
    }
  });
  ViewsFigures mean;
  for (std::size_t v = 0; v < per_view.size(); ++v) {
    const View& view = set.views[v];
    const double share = set.share(view);
    ViewFigures& into = view.inside ? mean.inside : mean.outside;
    into.draws += share * per_view[v].draws;
    into.triangles += share * per_view[v].triangles;
    into.cost += share * per_view[v].cost;
  }
  return mean;
}

ViewSet::ViewSet(const Profile& profile_, std::vector<View> views_)
    : profile(profile_), views(std::move(views_)) {
  for (const View& view : views) {
    ++(view.inside ? inside : outside);
    (view.inside ? inside_weight : outside_weight) += view.weight;
  }
}

ViewSet make_view_set(const scene::Scene& scene, const hierarchy::Hierarchy& tree,
                      const Viewpoints& viewpoints) {
  ViewSet set(viewpoints.profile(), viewpoints.sample(kInsideViews, kOutsideViews));
  std::vector<std::uint64_t> ideal(set.views.size());
  parallel_for(ideal.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v)
      ideal[v] = ideal_triangles(scene, tree, Frustum(set.views[v], set.profile));
  });
  for (std::size_t v = 0; v < ideal.size(); ++v)
    (set.views[v].inside ? set.ideal_inside : set.ideal_outside) +=
        set.share(set.views[v]) * static_cast<double>(ideal[v]);
  return set;
}

ViewsReport measure_views(const scene::Scene& scene, const ViewSet& set, const BatchPlan& plan) {
  ViewsReport report;
  report.inside_views = set.inside;
  report.outside_views = set.outside;
  report.ideal_inside = set.ideal_inside;
  report.ideal_outside = set.ideal_outside;
  report.before = measure_draws(set, draws_of_input(scene));
  report.after = measure_draws(set, draws_of_plan(scene, plan));
  return report;
}

}  // namespace lightbatch::batches
