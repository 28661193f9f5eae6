#pragma once

#include <algorithm>
#include <vector>

#include "core/radiosity/solver.h"

namespace lightbatch::radiosity {

/// The stored hits: rows by element. Weights only where a scene has sheets (else all are 1).
struct Links {
  std::vector<std::uint64_t> start;  // per element and one past
  std::vector<ElementId> source;
  std::vector<Rgb> weight;
  std::vector<float> scale;  // 1 / rays of the row
  std::uint64_t memory_bytes() const {
    return start.capacity() * 8 + source.capacity() * 4 + weight.capacity() * 12 +
           scale.capacity() * 4;
  }
};

/// What the stored rays found.
struct Shot {
  /// Nothing yet.
  explicit Shot(const SolverInput& input)
      : sky(input.elements.count()),
        resolved(input.elements.count()),
        resolved_by_group(input.groups > 0 ? input.elements.count() : 0, input.groups),
        crowding(input.elements.count()) {}
  /// Forgets what surfaces send.
  void drop_links() {
    links = {};
    std::fill(resolved.begin(), resolved.end(), Rgb{});
    resolved_by_group = GroupedLight(sky.size(), resolved_by_group.groups());
  }
  Links links;
  std::vector<Rgb> sky;       // irradiance from rays that left the scene, per element, lux
  std::vector<Rgb> resolved;  // irradiance by what resolved lights bring to where rays land, lux
  GroupedLight resolved_by_group;  // the same by light group; empty: not asked
  std::vector<float> crowding;     // as in Solution
};

/// Shoots the cosine rays of every element. direct: as measure_direct leaves it. Sharp shadows
/// where rays land keep sunlight on the outer half of an element that lies partly inside from
/// lighting the room.
Shot shoot(const SolverInput& input, const SolverOptions& options, const Solution& direct,
           RayCounts& counts, const Progress& progress);

/// (K x)_e: what the linked elements send to e.
inline Rgbd row_sum(const Links& links, ElementId e, const std::vector<Rgb>& x) {
  Rgbd sum;
  if (links.weight.empty()) {
    for (auto k = links.start[e]; k < links.start[e + 1]; ++k) {
      sum += to_double(x[links.source[k]]);
    }
  } else {
    for (auto k = links.start[e]; k < links.start[e + 1]; ++k) {
      sum += to_double(x[links.source[k]] * links.weight[k]);
    }
  }
  return sum * static_cast<double>(links.scale[e]);
}

}  // namespace lightbatch::radiosity
