#pragma once

#include <cstdint>
#include <span>

#include "core/lightmap/bake.h"
#include "core/lightmap/texel_points.h"

namespace lightbatch::lightmap {

/// What a few shadow rays say of a texel: which lights it sees.
struct DirectPilot {
  enum Emitters : std::uint8_t { kNotAsked, kDark, kLit, kMixed };
  bool measured = false;
  bool thorough = false;  // asked in: punctual lights are to be asked from several points
  Emitters emitters = kNotAsked;
  bool punctual_mixed = false;  // some punctual light is seen in part, by the pilot itself
  std::uint32_t punctual = 0;   // hash of the punctual lights' states
};

/// Emitters' light at a texel, with what it would be without shadows.
struct EmitterPart {
  Rgb arrives;
  Rgb open;
  float slack = 0;  // of the visible share: three standard errors, about
};

/// Measures direct light at texels. Unoccluded irradiance is exact (polygons, formulas), only
/// visibility is sampled; the number of samples follows from what an error of visibility costs
/// against the scene's mean irradiance. by_group, where it is not empty, is set to what arrives
/// from each light group. Thread-safe.
class DirectTexel {
 public:
  DirectTexel(const BakeInput& input, const GatherSettings& settings);

  EmitterPart pilot_emitters(std::uint32_t t, DirectPilot& pilot, std::span<Rgb> by_group,
                             BakeCounts& counts) const;
  Rgb pilot_punctual(std::uint32_t t, DirectPilot& pilot, std::span<Rgb> by_group,
                     BakeCounts& counts) const;

  /// open: unoccluded irradiance as the pilot found it, lux.
  EmitterPart refined_emitters(std::uint32_t t, const Rgb& open, std::span<Rgb> by_group,
                               BakeCounts& counts) const;
  /// Mean over the texel; where a shadow's edge runs, only the sixteenths of the texel that it
  /// touches are sampled on.
  Rgb refined_punctual(std::uint32_t t, std::span<Rgb> by_group, BakeCounts& counts) const;

 private:
  EmitterPart emitters(std::uint32_t t, std::uint32_t wanted, int rays, std::span<Rgb> by_group,
                       radiosity::VisibilitySum& seen, BakeCounts& counts) const;
  Rgbd one_light(std::uint32_t t, std::size_t light, const TexelPoints& points,
                 BakeCounts& counts) const;
  /// Samples of an edge whose visibility error costs direct_error of the mean irradiance.
  int samples_for(double open, double constant, int most) const;

  const BakeInput& input_;
  const GatherSettings& settings_;
  const std::vector<radiosity::PunctualLight>& lights_;
};

}  // namespace lightbatch::lightmap
