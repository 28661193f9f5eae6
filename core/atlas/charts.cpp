#include <algorithm>
#include <cmath>

#include "core/atlas/facets.h"
#include "core/atlas/grow.h"
#include "core/atlas/split.h"

namespace lightbatch::atlas {
namespace {

using scene::kNone;

std::vector<std::uint32_t> connected_parts(const Mesh& mesh, const Facets& facets) {
  std::vector<std::uint32_t> part_of(facets.size(), kNone), stack;
  std::uint32_t parts = 0;
  for (std::uint32_t seed = 0; seed < facets.size(); ++seed) {
    if (part_of[seed] != kNone) continue;
    part_of[seed] = parts;
    stack.push_back(seed);
    while (!stack.empty()) {
      const std::uint32_t facet = stack.back();
      stack.pop_back();
      for (const std::uint32_t t : facets.triangles(facet)) {
        for (std::uint32_t k = 0; k < 3; ++k) {
          const std::uint32_t twin = mesh.twin[3 * t + k];
          if (twin == kNone) continue;
          const std::uint32_t other = facets.of[twin / 3];
          if (part_of[other] != kNone) continue;
          part_of[other] = parts;
          stack.push_back(other);
        }
      }
    }
    ++parts;
  }
  return part_of;
}

/// Parts that are mostly faces along the frame's axes: cutting others along axes never helped.
std::vector<bool> aligned_parts(const Facets& facets, const std::vector<std::uint32_t>& part_of,
                                std::size_t parts, const Affine& frame) {
  const Vec3d axes[3] = {normalized(frame.x), normalized(frame.y), normalized(frame.z)};
  std::vector<double> all(parts, 0.0), along(parts, 0.0);
  for (std::uint32_t f = 0; f < facets.size(); ++f) {
    all[part_of[f]] += facets.areas[f];
    for (const Vec3d& axis : axes) {
      if (std::abs(dot(axis, facets.normals[f])) > 0.999) along[part_of[f]] += facets.areas[f];
    }
  }
  std::vector<bool> aligned(parts);
  for (std::size_t p = 0; p < parts; ++p) aligned[p] = along[p] >= 0.5 * all[p];
  return aligned;
}

/// Flattened charts of the facets that `take` accepts, in the order of their numbers.
template <typename Take>
ChartSet flatten(const Mesh& mesh, const Facets& facets,
                 const std::vector<std::uint32_t>& chart_of_facet, Take take,
                 ProjectScratch& scratch) {
  ChartSet set;
  set.of.assign(mesh.size(), kNone);
  std::uint32_t count = 0;
  for (const std::uint32_t c : chart_of_facet) count = std::max(count, c + 1);
  std::vector<std::vector<std::uint32_t>> members(count);
  std::vector<std::uint32_t> largest(count, kNone);  // facet: what the chart grew from
  for (std::uint32_t f = 0; f < facets.size(); ++f) {
    if (!take(f)) continue;
    const std::uint32_t c = chart_of_facet[f];
    if (largest[c] == kNone || facets.areas[f] > facets.areas[largest[c]]) largest[c] = f;
    auto& list = members[c];
    for (const std::uint32_t t : facets.triangles(f)) list.push_back(t);
  }
  std::uint32_t next = 0;
  for (auto& list : members) {
    if (list.empty()) continue;
    std::sort(list.begin(), list.end());
    for (const std::uint32_t t : list) set.of[t] = next;
    ++next;
  }
  for (std::uint32_t c = 0; c < count; ++c) {
    if (members[c].empty()) continue;
    const Vec3d hint = facets.normals[largest[c]];
    set.charts.push_back(project_chart(mesh, std::move(members[c]), hint, set.of, scratch));
  }
  return set;
}

}  // namespace

ChartSet make_charts(const Mesh& mesh, const Affine& frame, double density, int max_side) {
  const Facets facets = find_facets(mesh);
  ProjectScratch scratch;
  const auto all = [](std::uint32_t) { return true; };
  ChartSet grown = flatten(mesh, facets, grow_charts(mesh, facets), all, scratch);

  const std::vector<std::uint32_t> part_of = connected_parts(mesh, facets);
  std::size_t parts = 0;
  for (const std::uint32_t p : part_of) parts = std::max<std::size_t>(parts, p + 1);
  const std::vector<bool> aligned = aligned_parts(facets, part_of, parts, frame);
  const auto in_aligned = [&](std::uint32_t f) { return aligned[part_of[f]]; };
  ChartSet boxed = flatten(mesh, facets, box_charts(mesh, facets, frame), in_aligned, scratch);
  if (boxed.charts.empty()) return grown;

  // Concave charts pack badly: part of the empty rest of the rectangle counts too.
  const auto cost = [&](const FlatChart& chart) {
    const double outline = footprint_estimate(chart, density, max_side);
    const Vec2d scale = chart_scale(chart, density, max_side);
    const double rectangle = chart.width * scale.x * chart.height * scale.y;
    return outline + 0.2 * std::max(0.0, rectangle - outline);
  };
  std::vector<double> gain(parts, 0.0);  // of boxes over growing
  const auto part_of_chart = [&](const FlatChart& chart) {
    return part_of[facets.of[chart.triangles[0]]];
  };
  for (const FlatChart& chart : grown.charts) gain[part_of_chart(chart)] += cost(chart);
  for (const FlatChart& chart : boxed.charts) gain[part_of_chart(chart)] -= cost(chart);

  ChartSet best;
  best.of.assign(mesh.size(), kNone);
  const auto take = [&](ChartSet& from, bool boxes) {
    for (FlatChart& chart : from.charts) {
      const std::uint32_t part = part_of_chart(chart);
      if ((aligned[part] && gain[part] > 0) != boxes) continue;
      for (const std::uint32_t t : chart.triangles) {
        best.of[t] = static_cast<std::uint32_t>(best.charts.size());
      }
      best.charts.push_back(std::move(chart));
    }
  };
  take(grown, false);
  take(boxed, true);
  return best;
}

}  // namespace lightbatch::atlas
