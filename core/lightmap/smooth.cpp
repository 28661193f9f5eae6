#include "core/lightmap/smooth.h"

#include <cmath>

#include "core/base/parallel.h"
#include "core/lightmap/neighbours.h"

namespace lightbatch::lightmap {
namespace {

/// Neighbours whose normals differ more than this (cosine) are not of one surface.
constexpr float kSameSurface = 0.97f;
/// A pair is off the line when it is by more than this many standard errors of a + b - 2 c.
constexpr float kDeviations = 2.0f;

float square(float v) { return v * v; }
float brightness(const GatheredTexel& t) { return t.irradiance.sum() / 3; }

}  // namespace

std::vector<Rgb> smooth_gathered(const BakeInput& input, const std::vector<GatheredTexel>& texels) {
  std::vector<Rgb> smooth(texels.size());
  parallel_for(texels.size(), 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const GatheredTexel& own = texels[i];
      smooth[i] = own.irradiance;
      if (!own.gathered) continue;
      const auto at = neighbourhood(input.texels, input.layout, static_cast<std::uint32_t>(i));
      // A variance from two halves is rough; the neighbourhood's, as a share of the light there, is
      // steadier and stays small for a dark texel beside bright ones.
      float variance = 0, squares = 0;
      for (const std::uint32_t n : at) {
        if (n == scene::kNone || !texels[n].gathered) continue;
        variance += texels[n].variance;
        squares += square(brightness(texels[n]));
      }
      if (!(squares > 0)) continue;
      const float relative = variance / squares;
      Rgb sum = own.irradiance;
      float weight = 1;
      for (std::size_t k = 0; k < 4; ++k) {
        if (at[k] == scene::kNone || at[8 - k] == scene::kNone) continue;
        const GatheredTexel& a = texels[at[k]];
        const GatheredTexel& b = texels[at[8 - k]];
        const auto apart = [&](const GatheredTexel& n) {
          return n.covered != own.covered ||
                 (n.gathered && dot(n.normal, own.normal) < kSameSurface);
        };
        if (apart(a) || apart(b)) continue;
        const Rgb bend = a.irradiance + b.irradiance - own.irradiance * 2;
        const float expected =
            square(brightness(a)) + square(brightness(b)) + 4 * square(brightness(own));
        if (square(bend.sum() / 3) > square(kDeviations) * relative * expected) continue;
        sum += a.irradiance + b.irradiance;
        weight += 2;
      }
      smooth[i] = sum * (1 / weight);
    }
  });
  return smooth;
}

}  // namespace lightbatch::lightmap
