#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "core/batches/assignment.h"

namespace lightbatch::batches {
namespace {

/// One object's triangles under one key, and how the cut spread them.
struct Item {
  std::uint32_t object = 0, key = 0;
  Share all;
  std::vector<std::pair<std::uint32_t, Share>> parts;  // batch, ascending
};

std::uint64_t slot(std::uint32_t batch, std::uint32_t key) {
  return (std::uint64_t{batch} << 32) | key;
}

Share triangle_share(const scene::Scene& scene, const KeyMap& keys, std::uint32_t triangle) {
  Share share;
  share.key = keys.of_triangle[triangle];
  share.triangles = 1;
  share.vertices = keys.vertices_of_object[scene.triangles[triangle].object];
  for (const Vec3f& p : scene.corners(triangle)) share.box.add(p);
  return share;
}

/// The items of one object that are in more than one batch; every share is added to `shares`.
void gather_items(const scene::Scene& scene, const KeyMap& keys,
                  const std::vector<std::uint32_t>& batch_of, std::uint32_t object,
                  std::unordered_map<std::uint64_t, Share>& shares, std::vector<Item>& split) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;  // (key, batch), triangle
  const scene::Object& o = scene.objects[object];
  for (std::uint32_t k = 0; k < o.triangle_count; ++k) {
    const std::uint32_t t = o.first_triangle + k;
    if (batch_of[t] != scene::kNone) order.emplace_back(slot(keys.of_triangle[t], batch_of[t]), t);
  }
  std::sort(order.begin(), order.end());
  Item item;
  const auto finish = [&] {
    if (item.parts.size() > 1) split.push_back(std::move(item));
    item = Item{};
  };
  for (std::size_t i = 0; i < order.size();) {
    const std::uint32_t batch = static_cast<std::uint32_t>(order[i].first);
    Share part;
    std::size_t end = i;
    for (; end < order.size() && order[end].first == order[i].first; ++end) {
      const Share share = triangle_share(scene, keys, order[end].second);
      part.key = share.key;
      part.add(share);
    }
    i = end;
    if (!item.parts.empty() && item.key != part.key) finish();
    item.object = object;
    item.key = item.all.key = part.key;
    item.all.add(part);
    item.parts.emplace_back(batch, part);
    const auto [it, fresh] = shares.try_emplace(slot(batch, part.key), part);
    if (!fresh) it->second.add(part);
  }
  finish();
}

}  // namespace

std::uint32_t keep_objects_whole(const scene::Scene& scene, const KeyMap& keys,
                                 const Prices& prices, std::uint32_t max_vertices,
                                 const ViewDistribution& views,
                                 std::vector<std::uint32_t>& batch_of) {
  std::unordered_map<std::uint64_t, Share> shares;
  std::vector<Item> split;
  for (std::uint32_t o = 0; o < scene.objects.size(); ++o)
    gather_items(scene, keys, batch_of, o, shares, split);
  std::stable_sort(split.begin(), split.end(),
                   [](const Item& a, const Item& b) { return a.all.triangles < b.all.triangles; });

  const auto cost = [&](const Share& s) {
    if (s.triangles == 0) return 0.0;
    return frame_of(s, views.chance(s.box), max_vertices).cost(prices);
  };
  std::vector<bool> stays_split(scene.objects.size(), false);
  for (const Item& item : split) {
    // Leaving a batch: its box is taken as it is, so that a gain is never overstated.
    std::vector<double> gain(item.parts.size());
    double total_gain = 0;
    for (std::size_t i = 0; i < item.parts.size(); ++i) {
      const auto& [batch, part] = item.parts[i];
      const Share& from = shares.at(slot(batch, item.key));
      const Chance chance = views.chance(from.box);
      Share rest = from;
      rest.triangles -= part.triangles;
      rest.vertices = std::max(0.0, rest.vertices - part.vertices);
      const double after =
          rest.triangles == 0 ? 0 : frame_of(rest, chance, max_vertices).cost(prices);
      gain[i] = frame_of(from, chance, max_vertices).cost(prices) - after;
      total_gain += gain[i];
    }
    // Vertices along the cuts exist twice while the object is apart: about a row of each part.
    double duplicates = 0;
    for (const auto& [batch, part] : item.parts) duplicates += 2 * std::sqrt(part.vertices);
    total_gain += duplicates * prices.vertex * views.chance(item.all.box).any;

    double best = 0;
    std::size_t target = item.parts.size();
    for (std::size_t i = 0; i < item.parts.size(); ++i) {
      const auto& [batch, part] = item.parts[i];
      const Share& to = shares.at(slot(batch, item.key));
      Share grown = to;
      grown.triangles += item.all.triangles - part.triangles;
      grown.vertices += item.all.vertices - part.vertices;
      grown.box.add(item.all.box);
      const double change = cost(grown) - cost(to) - (total_gain - gain[i]);
      if (change < best) {
        best = change;
        target = i;
      }
    }
    if (target == item.parts.size()) {
      stays_split[item.object] = true;
      continue;
    }
    const std::uint32_t home = item.parts[target].first;
    for (std::size_t i = 0; i < item.parts.size(); ++i) {
      if (i == target) continue;
      Share& from = shares.at(slot(item.parts[i].first, item.key));
      from.triangles -= item.parts[i].second.triangles;
      from.vertices = std::max(0.0, from.vertices - item.parts[i].second.vertices);
    }
    Share& to = shares.at(slot(home, item.key));
    to.triangles += item.all.triangles - item.parts[target].second.triangles;
    to.vertices += item.all.vertices - item.parts[target].second.vertices;
    to.box.add(item.all.box);
    const scene::Object& object = scene.objects[item.object];
    for (std::uint32_t k = 0; k < object.triangle_count; ++k) {
      const std::uint32_t t = object.first_triangle + k;
      if (batch_of[t] != scene::kNone && keys.of_triangle[t] == item.key) batch_of[t] = home;
    }
  }
  return static_cast<std::uint32_t>(std::count(stays_split.begin(), stays_split.end(), true));
}

}  // namespace lightbatch::batches
