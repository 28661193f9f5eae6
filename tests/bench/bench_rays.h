#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/rays/caster.h"
#include "tests/bench/bench_scenes.h"

namespace lightbatch::bench {

struct RaySet {
  std::string name;
  bool any = false;
  std::vector<rays::Ray> rays;
  /// For ff16: source and receiver triangle of each bundle of 16.
  std::vector<std::array<std::uint32_t, 2>> ends;
};

/// primary: pinhole, 4 x 2 blocks; bounce: cosine-weighted from the primary hits; pair: any-hit
/// between two random surface points; ff16: any-hit, 16 rays between the same two random triangles.
std::vector<RaySet> make_rays(const Scene& scene, const rays::Caster& caster, std::size_t count);

}  // namespace lightbatch::bench
