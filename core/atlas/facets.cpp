#include "core/atlas/facets.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lightbatch::atlas {

Facets find_facets(const Mesh& mesh) {
  using scene::kNone;
  const std::uint32_t count = mesh.size();
  // Thin triangles last: they join what is there and start facets only among themselves.
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const bool thin_a = mesh.slack[a] > kNoNormal, thin_b = mesh.slack[b] > kNoNormal;
    if (thin_a != thin_b) return thin_b;
    return mesh.areas[a] != mesh.areas[b] ? mesh.areas[a] > mesh.areas[b] : a < b;
  });

  Facets facets;
  facets.of.assign(count, kNone);
  facets.members.reserve(count);
  for (const std::uint32_t seed : order) {
    if (facets.of[seed] != kNone) continue;
    const std::uint32_t facet = facets.size();
    const Vec3d normal = mesh.normals[seed];
    facets.normals.push_back(normal);
    facets.first.push_back(static_cast<std::uint32_t>(facets.members.size()));
    double area = 0;
    facets.of[seed] = facet;
    facets.members.push_back(seed);
    for (std::size_t head = facets.first.back(); head < facets.members.size(); ++head) {
      const std::uint32_t t = facets.members[head];
      area += mesh.areas[t];
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t twin = mesh.twin[3 * t + k];
        if (twin == kNone || facets.of[twin / 3] != kNone) continue;
        const std::uint32_t other = twin / 3;
        const double slack = static_cast<double>(mesh.slack[other]);
        if (mesh.slack[other] <= kNoNormal) {
          const double angle = kCoplanarAngle + slack + static_cast<double>(mesh.slack[seed]);
          // |a - b| = 2 sin(angle / 2): keeps its precision for small angles.
          if (length(mesh.normals[other] - normal) > angle) continue;
        }
        facets.of[other] = facet;
        facets.members.push_back(other);
      }
    }
    facets.areas.push_back(area);
  }
  facets.first.push_back(static_cast<std::uint32_t>(facets.members.size()));
  return facets;
}

}  // namespace lightbatch::atlas
