#pragma once

#include <cstdint>
#include <span>

#include "core/lightmap/bake.h"
#include "core/lightmap/texel_points.h"

namespace lightbatch::lightmap {

/// What a few shadow rays say of a texel: which punctual lights it sees.
struct PunctualPilot {
  bool thorough = false;     // asked in: lights are to be asked from several points
  bool mixed = false;        // some light is seen in part, by the pilot itself, or uneven
  std::uint32_t states = 0;  // hash of how each light is seen
};

/// Measures the direct light of punctual lights at texels. Unoccluded irradiance is exact, only
/// visibility is sampled; the number of samples follows from what an error of visibility costs
/// against the scene's mean irradiance. by_group, where it is not empty, is set to what arrives
/// from each light group. Thread-safe.
class PunctualTexel {
 public:
  PunctualTexel(const BakeInput& input, const GatherSettings& settings);

  /// dim: share of the allowed error that the texel may be off by.
  Rgb pilot(std::uint32_t t, double dim, PunctualPilot& pilot, std::span<Rgb> by_group,
            BakeCounts& counts) const;

  /// Mean over the texel; where a shadow's edge runs, only the sixteenths of the texel that it
  /// touches are sampled on.
  Rgb refined(std::uint32_t t, double dim, std::span<Rgb> by_group, BakeCounts& counts) const;

 private:
  /// Whether some point of the texel sees another share of the light, as far as some dozens of rays
  /// tell.
  bool search(std::uint32_t t, const radiosity::PunctualLight& light, const Rgb& share,
              const TexelPoints& points, Receivers& receivers, BakeCounts& counts) const;
  /// The surface is there all over the texel, and rays from its corners end on the same triangle:
  /// all between them do.
  bool is_behind_one_triangle(const radiosity::PunctualLight& light, const TexelPoints& points,
                              Receivers& receivers, BakeCounts& counts) const;
  Rgbd one_light(std::uint32_t t, std::size_t light, const TexelPoints& points, double may_be_off,
                 BakeCounts& counts) const;

  const BakeInput& input_;
  const GatherSettings& settings_;
  double allowed_;  // lux that visibility may be off by
  const std::vector<radiosity::PunctualLight>& lights_;
};

}  // namespace lightbatch::lightmap
