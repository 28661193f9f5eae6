#include "core/atlas/grow.h"

#include <algorithm>
#include <numeric>
#include <queue>
#include <utility>

namespace lightbatch::atlas {

std::vector<std::uint32_t> grow_charts(const Mesh& mesh, const Facets& facets) {
  using scene::kNone;
  std::vector<std::uint32_t> seeds(facets.size());
  std::iota(seeds.begin(), seeds.end(), 0u);
  std::sort(seeds.begin(), seeds.end(), [&](std::uint32_t a, std::uint32_t b) {
    return facets.areas[a] != facets.areas[b] ? facets.areas[a] > facets.areas[b] : a < b;
  });

  std::vector<std::uint32_t> chart_of(facets.size(), kNone);
  std::uint32_t charts = 0;
  using Entry = std::pair<double, std::uint32_t>;  // minus the cosine to the seed, facet
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (const std::uint32_t seed : seeds) {
    if (chart_of[seed] != kNone) continue;
    const Vec3d normal = facets.normals[seed];
    queue.emplace(-1.0, seed);
    while (!queue.empty()) {
      const std::uint32_t facet = queue.top().second;
      queue.pop();
      if (chart_of[facet] != kNone) continue;
      chart_of[facet] = charts;
      for (const std::uint32_t t : facets.triangles(facet)) {
        for (std::uint32_t k = 0; k < 3; ++k) {
          const std::uint32_t twin = mesh.twin[3 * t + k];
          if (twin == kNone) continue;
          const std::uint32_t other = facets.of[twin / 3];
          if (chart_of[other] != kNone) continue;
          const double cosine = dot(normal, facets.normals[other]);
          if (cosine < kConeCosine) continue;
          if (dot(facets.normals[facet], facets.normals[other]) < kFoldCosine) continue;
          queue.emplace(-cosine, other);
        }
      }
    }
    ++charts;
  }
  return chart_of;
}

std::vector<std::uint32_t> box_charts(const Mesh& mesh, const Facets& facets, const Affine& frame) {
  using scene::kNone;
  const Vec3d axes[3] = {normalized(frame.x), normalized(frame.y), normalized(frame.z)};
  std::vector<std::uint8_t> side(facets.size());
  for (std::uint32_t f = 0; f < facets.size(); ++f) {
    double best = -2;
    for (std::uint8_t s = 0; s < 6; ++s) {
      const double cosine = dot(axes[s / 2], facets.normals[f]) * (s % 2 == 0 ? 1.0 : -1.0);
      if (cosine > best) {
        best = cosine;
        side[f] = s;
      }
    }
  }
  std::vector<std::uint32_t> chart_of(facets.size(), kNone);
  std::vector<std::uint32_t> stack;
  std::uint32_t charts = 0;
  for (std::uint32_t seed = 0; seed < facets.size(); ++seed) {
    if (chart_of[seed] != kNone) continue;
    chart_of[seed] = charts;
    stack.push_back(seed);
    while (!stack.empty()) {
      const std::uint32_t facet = stack.back();
      stack.pop_back();
      for (const std::uint32_t t : facets.triangles(facet)) {
        for (std::uint32_t k = 0; k < 3; ++k) {
          const std::uint32_t twin = mesh.twin[3 * t + k];
          if (twin == kNone) continue;
          const std::uint32_t other = facets.of[twin / 3];
          if (chart_of[other] != kNone || side[other] != side[seed]) continue;
          if (dot(facets.normals[facet], facets.normals[other]) < kFoldCosine) continue;
          chart_of[other] = charts;
          stack.push_back(other);
        }
      }
    }
    ++charts;
  }
  return chart_of;
}

}  // namespace lightbatch::atlas
