#pragma once

#include <vector>

#include "core/atlas/layout.h"
#include "core/atlas/texels.h"
#include "core/math/rgb.h"
#include "core/math/vec.h"
#include "core/radiosity/light_groups.h"

namespace lightbatch::lightmap {

/// One texel's gathered light and what is known of it.
struct GatheredTexel {
  Rgb irradiance;      // lux
  float variance = 0;  // of the mean of the channels, estimated from the gather's own halves; 0:
                       // not gathered (shared)
  Vec3f normal;        // shared texels: as at a corner of their block
  float distance = 0;  // harmonic mean length of the rays, metres; shared: the corners' least
  bool gathered = false;
  bool covered = false;  // something is closer above it than the texel's edge
};

/// Evens out the gather's noise: a texel becomes the mean over itself and those pairs of opposite
/// texels that with it make a straight line, as far as the noise tells. Pairs keep gradients; what
/// bends by more than noise stays as it is. Repeated at 1, 2, 4 and 8 texels apart (a trous, as
/// Dammertz et al. 2010), the farther ones only where that is at most `reach` harmonic mean
/// distances. by_group (empty: not asked) goes through the same means.
void smooth_gathered(const atlas::Layout& layout, const atlas::TexelMap& map, double reach,
                     std::vector<GatheredTexel>& texels, radiosity::GroupedLight& by_group);

}  // namespace lightbatch::lightmap
