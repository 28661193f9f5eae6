#include "core/lightmap/ray_shares.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"

namespace lightbatch::lightmap {
namespace {

constexpr double kShareOfLight = 2 / 2.4;
/// Limits of a texel's rays against the mean: the first stage may be wrong about a texel.
constexpr float kFewestShare = 0.25f;
constexpr float kMostShare = 8.0f;

}  // namespace

std::vector<float> ray_shares(const BakeInput& input, const DimShares& dim,
                              const std::vector<Rgb>& first) {
  std::vector<float> share(first.size(), 1.0f);
  if (input.solution.indirect.empty()) return share;
  const double whole = 1 / (input.layout.texels_per_metre * input.layout.texels_per_metre);
  double mean = 0;
  for (std::size_t t = 0; t < share.size(); ++t) {
    const double part = std::min(1.0, input.texels.surface_of(input.texels.texels[t]) / whole);
    share[t] = first[t].sum() *
               static_cast<float>(std::sqrt(part) / dim.at(static_cast<std::uint32_t>(t)));
    mean += static_cast<double>(share[t]) / static_cast<double>(share.size());
  }
  if (!(mean > 0)) {
    share.assign(share.size(), 1.0f);
    return share;
  }
  double sum = 0;
  for (float& v : share) {
    v = std::clamp(static_cast<float>(std::pow(static_cast<double>(v) / mean, kShareOfLight)),
                   kFewestShare, kMostShare);
    sum += static_cast<double>(v);
  }
  const auto scale = static_cast<float>(static_cast<double>(share.size()) / sum);
  for (float& v : share) v *= scale;
  return share;
}

}  // namespace lightbatch::lightmap
