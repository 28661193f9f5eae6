#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/math/aabb.h"

namespace lightbatch::hierarchy::testing {

struct BoxSet {
  std::string name;
  std::vector<Aabb> boxes;
};

inline Aabb box_around(const Vec3f& centre, const Vec3f& half) {
  return {centre - half, centre + half};
}

inline std::vector<Aabb> random_boxes(std::size_t n, float size, std::uint64_t seed) {
  Random random(seed);
  std::vector<Aabb> boxes(n);
  for (Aabb& box : boxes) {
    const Vec3f centre{random.next_float(), random.next_float(), random.next_float()};
    box = box_around(centre,
                     Vec3f{random.next_float(), random.next_float(), random.next_float()} * size);
  }
  return boxes;
}

/// Flat boxes on a regular grid: equal costs and ties everywhere.
inline std::vector<Aabb> grid_boxes(int side) {
  std::vector<Aabb> boxes;
  for (int z = 0; z < side; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const Vec3f low{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
        boxes.push_back({low, low + Vec3f{1, 0, 1}});
      }
    }
  }
  return boxes;
}

/// Everything a scene file can do to a builder, n primitives each.
inline std::vector<BoxSet> hostile_sets(std::size_t n) {
  std::vector<BoxSet> sets;
  sets.push_back({"identical", std::vector<Aabb>(n, Aabb{{1, 2, 3}, {4, 5, 6}})});
  sets.push_back({"one point", std::vector<Aabb>(n, Aabb{{1, 2, 3}, {1, 2, 3}})});
  BoxSet same_centre{"same centre", {}};
  BoxSet nested{"nested, growing fast", {}};
  BoxSet huge{"one huge among many tiny", {}};
  BoxSet slivers{"slivers", {}};
  BoxSet far{"extreme coordinates", {}};
  BoxSet line{"on a line", {}};
  Random random(7);
  for (std::size_t i = 0; i < n; ++i) {
    const float f = static_cast<float>(i);
    same_centre.boxes.push_back(box_around({}, Vec3f{f + 1, 2 * f + 1, 3 * f + 1}));
    const float grown = std::ldexp(1.0f, static_cast<int>(i % 250) - 125);
    nested.boxes.push_back({{0, 0, 0}, {grown, grown, grown}});
    const Vec3f at{random.next_float(), random.next_float(), random.next_float()};
    huge.boxes.push_back(i == n / 2 ? box_around({}, {1e6f, 1e6f, 1e6f})
                                    : box_around(at, {1e-3f, 1e-3f, 1e-3f}));
    slivers.boxes.push_back(
        box_around(at, i % 2 == 0 ? Vec3f{1e3f, 1e-3f, 1e-3f} : Vec3f{1e-3f, 1e-3f, 1e3f}));
    const float sign = i % 2 == 0 ? 1.0f : -1.0f;
    far.boxes.push_back(box_around(at * (sign * 1e38f), {1e37f, 1e37f, 1e37f}));
    line.boxes.push_back({{f, 0, 0}, {f + 1, 0, 0}});
  }
  for (BoxSet* set : {&same_centre, &nested, &huge, &slivers, &far, &line}) {
    sets.push_back(std::move(*set));
  }
  return sets;
}

}  // namespace lightbatch::hierarchy::testing
