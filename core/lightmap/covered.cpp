#include "core/lightmap/covered.h"

#include "core/base/parallel.h"
#include "core/lightmap/texel_points.h"

namespace lightbatch::lightmap {

std::vector<std::uint8_t> find_covered(const BakeInput& input) {
  std::vector<std::uint8_t> covered(input.texels.texels.size());
  const auto edge = static_cast<float>(1.0 / input.layout.texels_per_metre);
  parallel_for(covered.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      if (input.selected != nullptr && (*input.selected)[t] == 0) continue;
      const auto at =
          receiver_at(input.scene, input.layout,
                      central_point(input.texels, input.texels.texels[t]), input.direct.lift());
      const rays::Ray up{at.frame.origin, at.frame.normal, 0.0f, edge};
      covered[t] = input.caster.occluded(up, at.triangle) ? 1 : 0;
    }
  });
  return covered;
}

}  // namespace lightbatch::lightmap
