#pragma once

#include <cstdint>
#include <vector>

#include "core/lightmap/bake.h"

namespace lightbatch::lightmap {

/// Where from the light of texels comes, for surfaces with normal maps: luminance of the incident
/// light as spherical harmonics of order 1, less the factor that all four coefficients share.
///
/// direction d = (integral of L w dw) / (integral of L dw) over the texel's hemisphere, world axes:
/// 0 <= |d| <= 1, 1 under light from one direction alone, d = n / 2 under a constant sky. With the
/// texel's irradiance E on its own normal n, irradiance on another normal m is, by order 1 of the
/// clamped cosine, E max(0, 1 + 2 d.m) / (1 + 2 d.n): exact under a constant sky.
struct DirectionalMap {
  std::vector<Vec3f> direction;  // per texel; 0 where no chart asks, and where no light comes
  std::uint64_t texels = 0;      // of charts that ask
  BakeCounts counts;
};

/// The charts in which some triangle's material has a normal map; one flag each.
std::vector<std::uint8_t> charts_with_normal_maps(const scene::Scene& scene,
                                                  const atlas::Layout& layout);

/// Rays of a texel, where its irradiance takes so many.
int directional_rays(int rays);

/// Directions of the flagged charts' texels, of the selected ones. The same bytes on any number of
/// threads. CANCELLED.
Result<DirectionalMap> bake_directional(const BakeInput& input, const GatherSettings& settings,
                                        const std::vector<std::uint8_t>& charts,
                                        const Progress& progress);

}  // namespace lightbatch::lightmap
