#pragma once

#include <cstddef>

#include "core/hierarchy/hierarchy.h"
#include "core/rays/caster.h"
#include "tests/bench/bench_rays.h"
#include "tests/bench/bench_scenes.h"

namespace lightbatch::bench {

struct Wrong {
  std::size_t rays = 0;
  std::size_t doubtful = 0;  // the oracle itself is within 1e-12 of an edge, or of equal distances
  std::size_t wrong = 0;
};
/// Random rays against Moeller-Trumbore in double over the binary tree with padded boxes.
Wrong check_against_oracle(const Scene& scene, const hierarchy::Hierarchy& tree,
                           const rays::Caster& caster, std::size_t count);

/// Rays from the centre line of the torus at vertices and edge midpoints that hit nothing.
std::size_t count_leaks(const Scene& torus, const rays::Caster& caster, std::size_t count);

}  // namespace lightbatch::bench
