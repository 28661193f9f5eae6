#pragma once

#include <cstdint>
#include <vector>

#include "core/lightmap/bake.h"

namespace lightbatch::lightmap {

/// What a place may be off by, over what one of mean light may: (own / mean)^exponent, 1 where it
/// is brighter; light below a two-hundredth of the mean counts as that. Fine targets ask for dim
/// places by their own light.
double dim_share(double own, double mean, double exponent);

/// The same for texels, before their light is known; of GatherSettings::dim.
class DimShares {
 public:
  DimShares(const BakeInput& input, const GatherSettings& settings);

  /// By all light that the first stage found there.
  double at(std::uint32_t t) const;
  /// By its indirect light and direct light of the texel, lux.
  double at(std::uint32_t t, const Rgb& direct) const;

 private:
  double mean_ = 0, exponent_ = 0;
  std::vector<float> whole_, indirect_;  // lux, per texel; empty: all shares are 1
};

}  // namespace lightbatch::lightmap
