#include "core/batches/instance_cuts.h"

#include <algorithm>
#include <map>

#include "core/base/parallel.h"
#include "core/hierarchy/hierarchy.h"

namespace lightbatch::batches {
namespace {

/// Parts of a mesh are not split below so many triangles, nor a mesh into more than so many leaves.
constexpr std::size_t kSmallestPart = 128;
constexpr std::size_t kMostParts = 64;
/// Boxes kept of all parts and placements.
constexpr std::size_t kMostBoxes = 400000;

Aabb box_of_triangle(const scene::Scene& scene, std::uint32_t triangle) {
  Aabb box;
  for (const Vec3f& p : scene.corners(triangle)) box.add(p);
  return box;
}

}  // namespace

InstanceCuts::InstanceCuts(const scene::Scene& scene, const KeyMap& keys,
                           std::vector<std::vector<std::uint32_t>> placements,
                           const ViewDistribution& views, const Prices& prices)
    : placements_(std::move(placements)) {
  std::uint64_t most = 0;
  for (std::size_t p = 0; p < placements_.size(); ++p) {
    std::uint64_t triangles = 0;
    for (const std::uint32_t o : placements_[p]) triangles += scene.objects[o].triangle_count;
    if (triangles > most) model_ = p;
    most = std::max(most, triangles);
  }
  std::map<std::uint32_t, std::vector<std::uint32_t>> by_key;
  for (const std::uint32_t o : placements_[model_]) {
    const scene::Object& object = scene.objects[o];
    for (std::uint32_t k = 0; k < object.triangle_count; ++k)
      by_key[keys.of_triangle[object.first_triangle + k]].push_back(object.first_triangle + k);
  }
  for (auto& [key, triangles] : by_key)
    add_parts(scene, keys, key, std::move(triangles), views, prices);
}

std::vector<Aabb> InstanceCuts::boxes_of(const scene::Scene& scene,
                                         const std::vector<std::uint32_t>& triangles) const {
  // Which primitive of its placement an object is.
  std::map<std::uint32_t, std::size_t> place;
  for (std::size_t k = 0; k < placements_[model_].size(); ++k) place[placements_[model_][k]] = k;
  std::vector<Aabb> boxes(placements_.size());
  parallel_for(boxes.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      std::uint32_t last = scene::kNone, at = 0, after = 0;
      for (const std::uint32_t t : triangles) {
        const scene::Triangle& model = scene.triangles[t];
        if (model.object != last) {
          last = model.object;
          const scene::Object& object = scene.objects[placements_[p][place.at(last)]];
          at = object.first_triangle;
          after = at + object.triangle_count;
          const auto first = scene.triangles.begin();
          at = static_cast<std::uint32_t>(
              std::lower_bound(first + at, first + after, model.source,
                               [](const scene::Triangle& triangle, std::uint32_t source) {
                                 return triangle.source < source;
                               }) -
              first);
        }
        while (at < after && scene.triangles[at].source < model.source) ++at;
        if (at < after && scene.triangles[at].source == model.source)
          boxes[p].add(box_of_triangle(scene, at));
      }
    }
  });
  return boxes;
}

InstanceCuts::Part InstanceCuts::make_part(const scene::Scene& scene, const KeyMap& keys,
                                           std::uint32_t key, std::vector<std::uint32_t> triangles,
                                           const std::vector<Aabb>& boxes,
                                           const ViewDistribution& views) const {
  Part part;
  part.key = key;
  part.triangles = std::move(triangles);
  double vertices = 0;
  for (const std::uint32_t t : part.triangles)
    vertices += keys.vertices_of_object[scene.triangles[t].object];
  // Cells are cut from a tree of their own: flat parts are stacked, long ones laid side by side.
  const std::vector<double> triangles_of(boxes.size(), static_cast<double>(part.triangles.size()));
  part.places = split_by_views(boxes, triangles_of, views);
  const std::uint32_t nodes = part.places.tree.size();
  part.cells.resize(nodes);
  parallel_for(nodes, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const auto i = static_cast<std::uint32_t>(k);
      Share share;
      share.triangles = std::uint64_t{part.places.count[i]} * part.triangles.size();
      share.vertices = vertices * part.places.count[i];
      // However many vertices there are, a group of instances is one call.
      part.cells[k] = frame_of(share, views.chance(part.places.box[i]), scene::kNone);
    }
  });
  return part;
}

void InstanceCuts::add_parts(const scene::Scene& scene, const KeyMap& keys, std::uint32_t key,
                             std::vector<std::uint32_t> triangles, const ViewDistribution& views,
                             const Prices& prices) {
  const std::size_t most =
      std::clamp(kMostBoxes / (4 * placements_.size()), std::size_t{1}, kMostParts);
  const std::size_t smallest = std::max(kSmallestPart, triangles.size() / most);
  std::vector<Aabb> boxes;
  for (const std::uint32_t t : triangles) boxes.push_back(box_of_triangle(scene, t));
  const hierarchy::Hierarchy tree = hierarchy::build(boxes);
  const auto triangles_of = [&](std::uint32_t node) {
    std::vector<std::uint32_t> list;
    for (const std::uint32_t k : tree.primitives(node)) list.push_back(triangles[k]);
    std::sort(list.begin(), list.end());
    return list;
  };
  const auto is_smallest = [&](std::uint32_t node) {
    return tree.is_leaf(node) || tree.count(node) <= smallest;
  };
  // Boxes of the smallest parts in every placement; those of others are unions.
  std::vector<std::pair<std::uint32_t, std::vector<Aabb>>> chunks;  // first leaf, by placement
  std::vector<std::uint32_t> nodes{0};
  while (!nodes.empty()) {
    const std::uint32_t node = nodes.back();
    nodes.pop_back();
    if (is_smallest(node)) {
      chunks.emplace_back(tree.first(node), boxes_of(scene, triangles_of(node)));
    } else {
      nodes.push_back(tree.right(node));
      nodes.push_back(tree.left(node));
    }
  }
  const auto add_part = [&](std::uint32_t node) {
    std::vector<Aabb> all(placements_.size());
    for (const auto& [first, list] : chunks)
      if (first >= tree.first(node) && first < tree.first(node) + tree.count(node))
        for (std::size_t p = 0; p < all.size(); ++p) all[p].add(list[p]);
    parts_.push_back(make_part(scene, keys, key, triangles_of(node), all, views));
    return static_cast<std::uint32_t>(parts_.size() - 1);
  };

  roots_.push_back(add_part(0));
  std::vector<std::pair<std::uint32_t, std::uint32_t>> stack{{roots_.back(), 0}};  // part, node
  while (!stack.empty()) {
    const auto [index, node] = stack.back();
    stack.pop_back();
    if (is_smallest(node)) continue;
    Frame frame;
    for (const std::uint32_t c : best_cells(parts_[index], prices).cells)
      frame += parts_[index].cells[c];
    if (frame.cost({0, prices.vertex, prices.triangle}) <= frame.draws * prices.draw) continue;
    for (const std::uint32_t child : {tree.left(node), tree.right(node)}) {
      const std::uint32_t id = add_part(child);
      (child == tree.left(node) ? parts_[index].left : parts_[index].right) = id;
      stack.emplace_back(id, child);
    }
  }
}

InstanceCuts::Choice InstanceCuts::best_cells(const Part& part, const Prices& prices) const {
  std::vector<double> cost(part.cells.size());
  for (std::size_t i = 0; i < cost.size(); ++i) cost[i] = part.cells[i].cost(prices);
  Cut cut = best_cut(part.places.tree, cost, 0);
  return {cut.cost, std::move(cut.nodes)};
}

template <typename Visit>
void InstanceCuts::for_each_chosen(const Prices& prices, const Visit& visit) const {
  std::vector<Choice> choice(parts_.size());
  std::vector<double> best(parts_.size());
  std::vector<bool> split(parts_.size(), false);
  for (std::size_t i = parts_.size(); i-- > 0;) {
    choice[i] = best_cells(parts_[i], prices);
    best[i] = choice[i].cost;
    if (parts_[i].left == scene::kNone) continue;
    const double below = best[parts_[i].left] + best[parts_[i].right];
    split[i] = below < best[i];
    if (split[i]) best[i] = below;
  }
  std::vector<std::uint32_t> stack(roots_.rbegin(), roots_.rend());
  while (!stack.empty()) {
    const std::uint32_t i = stack.back();
    stack.pop_back();
    if (split[i]) {
      stack.push_back(parts_[i].right);
      stack.push_back(parts_[i].left);
    } else {
      visit(parts_[i], choice[i].cells);
    }
  }
}

Frame InstanceCuts::solve(const Prices& prices) const {
  Frame frame;
  for_each_chosen(prices, [&](const Part& part, const std::vector<std::uint32_t>& cells) {
    for (const std::uint32_t c : cells) frame += part.cells[c];
  });
  return frame;
}

void InstanceCuts::take(const scene::Scene& scene, const KeyMap& keys, const Prices& prices,
                        std::vector<InstancePart>& parts, std::vector<InstanceCell>& cells) const {
  for_each_chosen(prices, [&](const Part& chosen, const std::vector<std::uint32_t>& nodes) {
    InstancePart part;
    part.mesh = scene.objects[placements_[model_].front()].mesh;
    for (const std::uint32_t t : chosen.triangles) {
      const std::uint32_t o = scene.triangles[t].object;
      if (part.pieces.empty() || part.pieces.back().object != o) part.pieces.push_back({o, {}});
      auto& ranges = part.pieces.back().ranges;
      if (!ranges.empty() && ranges.back().first + ranges.back().count == t)
        ++ranges.back().count;
      else
        ranges.push_back({t, 1});
    }
    const scene::Object& first = scene.objects[part.pieces.front().object];
    part.material = first.material;
    part.layout = keys.keys[chosen.key].layout;
    part.whole = part.pieces.size() == 1 && chosen.triangles.size() == first.triangle_count;
    for (const Piece& piece : part.pieces)
      part.coloured = part.coloured || scene.objects[piece.object].material != part.material;
    for (const std::uint32_t node : nodes) {
      InstanceCell cell;
      cell.part = static_cast<std::uint32_t>(parts.size());
      cell.box = chosen.places.box[node];
      const auto members = chosen.places.clusters(node);
      std::vector<std::uint32_t> sorted(members.begin(), members.end());
      std::sort(sorted.begin(), sorted.end());
      for (const std::uint32_t m : sorted) cell.objects.push_back(placements_[m].front());
      cell.triangles = std::uint64_t{chosen.triangles.size()} * sorted.size();
      cells.push_back(std::move(cell));
    }
    parts.push_back(std::move(part));
  });
}

}  // namespace lightbatch::batches
