#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/progress.h"
#include "core/base/status.h"
#include "core/lightmap/bake.h"
#include "core/lightmap/gather.h"
#include "core/math/rgb.h"
#include "core/math/sh.h"
#include "core/probes/grid.h"

namespace lightbatch::probes {

/// Irradiance at a point, lux, as a function of the receiver's unit normal n:
///   E(n) = sum over k of coefficient[k] * sh_basis(n)[k]
/// The clamped cosine is folded in: coefficient = kShCosine * (projection of the incident
/// luminance), so that a sky of L nits gives pi L sqrt(4 pi) in the first and nothing else.
struct ShIrradiance {
  std::array<Rgb, 9> coefficient{};
  Rgb at(const Vec3f& normal) const {
    const Sh9 basis = sh_basis(normal);
    Rgb sum;
    for (std::size_t k = 0; k < basis.size(); ++k) sum += coefficient[k] * basis[k];
    return sum;
  }
};

struct ProbeSettings {
  double error = 0.02;  // noise allowed: root mean square over probes and normals, against the mean
  std::uint32_t fewest_rays = 64;
  std::uint32_t most_rays = 8192;
};

struct LightProbes {
  ProbeGrid grid;
  std::vector<ShIrradiance> irradiance;  // of grid.positions
  /// Of grid.positions; 0: inside something solid (most of what it sees shows its absorbing back).
  /// Invalid probes hold the mean of valid ones that share a cell with them, or nothing.
  std::vector<std::uint8_t> valid;
  double noise = 0;  // as in ProbeSettings::error, as estimated
  lightmap::BakeCounts counts;
};

/// Light of every probe: punctual lights with one shadow ray each, emitters by random points of
/// them, surfaces and sky by rays over the sphere, doubled until the two halves of a probe's rays
/// agree. The same bytes on any number of threads. CANCELLED.
Result<LightProbes> bake_probes(const lightmap::BakeInput& input, const lightmap::Gather& gather,
                                ProbeGrid grid, const ProbeSettings& settings,
                                const Progress& progress);

}  // namespace lightbatch::probes
