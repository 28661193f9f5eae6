#pragma once

#include <span>

#include "core/lightmap/bake.h"
#include "core/lightmap/texel_points.h"
#include "core/radiosity/virtual_lights.h"

namespace lightbatch::lightmap {

/// Light of one texel from virtual lights: rays to some of them, dealt by what each would bring to
/// the texel's centre with nothing between. What VirtualLights::serves says of a hit is brought
/// here, and the texel's other rays leave it out.
class VirtualTexel {
 public:
  /// Both outlive it.
  VirtualTexel(const BakeInput& input, const radiosity::VirtualLights& lights)
      : input_(input), lights_(lights) {}

  struct Value {
    Rgbd irradiance;        // lux
    double difference = 0;  // of the mean of the channels, between the two halves of the rays
  };
  /// by_group: is added to; empty: not asked. served: scratch.
  Value operator()(const TexelPoints& points, const radiosity::VirtualLights::ReceiverPatch& centre,
                   int rays, std::uint32_t seed, radiosity::VirtualLights::Served& served,
                   std::span<Rgb> by_group, BakeCounts& counts) const;

 private:
  const BakeInput& input_;
  const radiosity::VirtualLights& lights_;
};

}  // namespace lightbatch::lightmap
