#include <algorithm>
#include <cmath>
#include <map>

#include "core/batches/assignment.h"
#include "core/batches/cut.h"
#include "core/hierarchy/hierarchy.h"

namespace lightbatch::batches {
namespace {

/// All placements of one mesh: the objects of one node (and GPU instance) each.
struct Shared {
  std::uint32_t mesh = 0;
  std::vector<std::vector<std::uint32_t>> placements;  // objects, by primitive
  double bytes = 0;                                    // of one copy
};

Aabb box_of(const scene::Scene& scene, std::uint32_t object) {
  Aabb box;
  const scene::Object& o = scene.objects[object];
  for (std::uint32_t k = 0; k < o.triangle_count; ++k)
    for (const Vec3f& p : scene.corners(o.first_triangle + k)) box.add(p);
  return box;
}

/// Rotation, positive scale and translation say all: instances can be stored so.
bool is_plain_placement(const scene::Object& object) {
  const Affine& m = object.to_world;
  const double xx = dot(m.x, m.x), yy = dot(m.y, m.y), zz = dot(m.z, m.z);
  constexpr double kShear = 1e-5;  // cosine between axes
  return m.determinant() > 0 && std::abs(dot(m.x, m.y)) <= kShear * std::sqrt(xx * yy) &&
         std::abs(dot(m.y, m.z)) <= kShear * std::sqrt(yy * zz) &&
         std::abs(dot(m.z, m.x)) <= kShear * std::sqrt(zz * xx);
}

std::vector<Shared> shared_meshes(const scene::Scene& scene, const KeyMap& keys,
                                  const BatchOptions& options, double* geometry_bytes) {
  std::map<std::uint32_t,
           std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>>>
      uses;
  for (std::uint32_t o = 0; o < scene.objects.size(); ++o) {
    const scene::Object& object = scene.objects[o];
    if (object.triangle_count == 0) continue;
    // Without an instance: kNone + 1 = 0 sorts first.
    uses[object.mesh][{object.node, object.instance + 1}].push_back(o);
  }
  std::vector<Shared> result;
  for (auto& [mesh, placements] : uses) {
    Shared shared;
    shared.mesh = mesh;
    for (auto& [where, objects] : placements) shared.placements.push_back(std::move(objects));
    for (const std::uint32_t o : shared.placements.front()) {
      const double triangles = scene.objects[o].triangle_count;
      const double vertex_bytes = options.traits.empty() ? 32 : options.traits[o].vertex_bytes;
      shared.bytes += triangles * (keys.vertices_of_object[o] * vertex_bytes + 3 * 2);
    }
    *geometry_bytes += shared.bytes;
    result.push_back(std::move(shared));
  }
  return result;
}

/// Cuts the instances of a mesh by space: cells of the cut through a hierarchy over their boxes.
std::vector<InstanceCell> cut_instances(const scene::Scene& scene, const Profile& profile,
                                        const ViewDistribution& views, const KeyMap& keys,
                                        const Shared& shared) {
  std::vector<Aabb> boxes;
  for (const auto& objects : shared.placements) {
    Aabb box;
    for (const std::uint32_t o : objects) box.add(box_of(scene, o));
    boxes.push_back(box);
  }
  const hierarchy::Hierarchy tree = hierarchy::build(boxes);
  CutTree cut_tree;
  std::vector<double> cost;
  for (std::uint32_t i = 0; i < tree.node_count(); ++i) {
    cut_tree.right.push_back(tree.is_leaf(i) ? 0 : tree.right(i));
    const double visible = views.visible(tree.box(i));
    double sum = 0;
    for (const std::uint32_t o : shared.placements.front()) {
      Share share;
      share.triangles = std::uint64_t{scene.objects[o].triangle_count} * tree.count(i);
      share.vertices = keys.vertices_of_object[o] * static_cast<double>(share.triangles);
      const double calls = visible * (profile.draw + profile.state);
      // However many vertices there are, a group of instances is one call.
      sum += calls + visible * (share.vertices * profile.vertex +
                                static_cast<double>(share.triangles) * profile.triangle);
    }
    cost.push_back(sum);
  }
  std::vector<InstanceCell> cells;
  for (const std::uint32_t node : best_cut(cut_tree, cost, 0).nodes) {
    InstanceCell cell;
    cell.mesh = shared.mesh;
    cell.box = tree.box(node);
    std::vector<std::uint32_t> members(tree.primitives(node).begin(), tree.primitives(node).end());
    std::sort(members.begin(), members.end());
    for (const std::uint32_t o : shared.placements[members.front()]) {
      cell.primitives.push_back(scene.objects[o].primitive);
      cell.triangles += std::uint64_t{scene.objects[o].triangle_count} * members.size();
    }
    for (const std::uint32_t m : members) cell.objects.push_back(shared.placements[m].front());
    cells.push_back(std::move(cell));
  }
  return cells;
}

}  // namespace

Fates decide_fates(const scene::Scene& scene, const Profile& profile, const BatchOptions& options,
                   const ViewDistribution& views, const KeyMap& keys) {
  Fates fates;
  fates.of_object.assign(scene.objects.size(), Fate::kMerged);
  fates.reason.resize(scene.objects.size());
  const auto leave = [&](std::uint32_t object, const std::string& reason) {
    fates.of_object[object] = Fate::kLeft;
    fates.reason[object] = reason;
  };
  for (std::uint32_t o = 0; o < scene.objects.size(); ++o) {
    if (!options.traits.empty() && !options.traits[o].keep.empty())
      leave(o, options.traits[o].keep);
    else if (scene.objects[o].triangle_count == 0)
      leave(o, "no triangle with an area");
    else if (scene.materials[scene.objects[o].material].alpha_mode == scene::AlphaMode::kBlend)
      leave(o, "blended: viewers sort it by object");
  }

  std::vector<Shared> meshes = shared_meshes(scene, keys, options, &fates.geometry_bytes);
  // The fewest bytes for each draw saved first.
  std::stable_sort(meshes.begin(), meshes.end(), [](const Shared& a, const Shared& b) {
    return a.bytes * static_cast<double>(b.placements.front().size()) <
           b.bytes * static_cast<double>(a.placements.front().size());
  });
  const double budget =
      std::max(0.0, options.max_growth - 1) * fates.geometry_bytes + options.free_growth_bytes;
  const bool cells_allowed = options.gpu_instancing && options.page_of_triangle.empty();
  for (const Shared& mesh : meshes) {
    if (mesh.placements.size() < 2) continue;
    const double copies = mesh.bytes * static_cast<double>(mesh.placements.size() - 1);
    if (fates.copied_bytes + copies <= budget) {
      fates.copied_bytes += copies;
      continue;
    }
    bool plain = cells_allowed;
    for (const auto& objects : mesh.placements)
      for (const std::uint32_t o : objects)
        plain = plain && is_plain_placement(scene.objects[o]) &&
                fates.of_object[o] == Fate::kMerged &&
                objects.size() == mesh.placements.front().size();
    std::vector<InstanceCell> cells;
    if (plain) cells = cut_instances(scene, profile, views, keys, mesh);
    for (const auto& objects : mesh.placements)
      for (const std::uint32_t o : objects)
        if (fates.of_object[o] == Fate::kMerged)
          leave(o, "instanced: copies would exceed the allowed growth");
    const bool already = scene.objects[mesh.placements.front().front()].instance != scene::kNone;
    if (already && cells.size() == 1) continue;  // as the file has it
    std::map<std::uint32_t, const std::vector<std::uint32_t>*> placement_of;
    for (const auto& objects : mesh.placements) placement_of[objects.front()] = &objects;
    for (InstanceCell& cell : cells) {
      if (cell.objects.size() < 2 && !already) continue;
      for (const std::uint32_t first : cell.objects)
        for (const std::uint32_t o : *placement_of.at(first)) {
          fates.of_object[o] = Fate::kInstanced;
          fates.reason[o].clear();
        }
      fates.cells.push_back(std::move(cell));
    }
  }
  return fates;
}

}  // namespace lightbatch::batches
