#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "tests/unit/scene_out/files.h"

namespace lightbatch::scene_out::testing {

std::vector<WorldTriangle> world_triangles(const scene::Scene& scene) {
  std::vector<WorldTriangle> result;
  result.reserve(scene.triangles.size());
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
    WorldTriangle w;
    const auto corners = scene.corners(t);
    for (std::size_t c = 0; c < 3; ++c) w.corner[c] = scene.origin + to_double(corners[c]);
    const scene::Material& material = scene.material_of(t);
    if (material.gltf_index != scene::kNone) w.material = material.name;
    result.push_back(std::move(w));
  }
  return result;
}

double largest_distance(const std::vector<WorldTriangle>& a, const std::vector<WorldTriangle>& b,
                        double reach) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  if (a.size() != b.size()) return kNone;
  // Cells of twice the reach by centroid: a partner lies in one of eight.
  const auto cell = [&](const Vec3d& p, int dx, int dy, int dz) {
    const auto at = [&](double v, int d) {
      return static_cast<std::int64_t>(std::floor(v / (2 * reach) + 0.5 * d));
    };
    std::uint64_t h = 0;
    for (const std::int64_t v : {at(p.x, dx), at(p.y, dy), at(p.z, dz)})
      h = (h ^ static_cast<std::uint64_t>(v)) * 0x9e3779b97f4a7c15ULL + 1;
    return h;
  };
  const auto centroid = [](const WorldTriangle& t) {
    return (t.corner[0] + t.corner[1] + t.corner[2]) / 3.0;
  };
  std::unordered_multimap<std::uint64_t, std::uint32_t> table;
  for (std::uint32_t i = 0; i < b.size(); ++i) table.emplace(cell(centroid(b[i]), 0, 0, 0), i);
  std::vector<bool> taken(b.size(), false);
  double largest = 0;
  for (const WorldTriangle& t : a) {
    double best = reach;
    std::uint32_t partner = scene::kNone;
    std::vector<std::uint64_t> looked;
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz) {
          const std::uint64_t h = cell(centroid(t), dx, dy, dz);
          if (std::find(looked.begin(), looked.end(), h) != looked.end()) continue;
          looked.push_back(h);
          const auto [first, last] = table.equal_range(h);
          for (auto it = first; it != last; ++it) {
            const WorldTriangle& other = b[it->second];
            if (taken[it->second] || other.material != t.material) continue;
            for (std::size_t shift = 0; shift < 3; ++shift) {
              double distance = 0;
              for (std::size_t c = 0; c < 3; ++c)
                distance = std::max(distance, length(t.corner[c] - other.corner[(c + shift) % 3]));
              if (distance < best || (distance == best && partner == scene::kNone)) {
                best = distance;
                partner = it->second;
              }
            }
          }
        }
    if (partner == scene::kNone) return kNone;
    taken[partner] = true;
    largest = std::max(largest, best);
  }
  return largest;
}

}  // namespace lightbatch::scene_out::testing
