#include "core/lightmap/smooth.h"

#include <array>
#include <cmath>

#include "core/base/parallel.h"
#include "core/lightmap/neighbours.h"

namespace lightbatch::lightmap {
namespace {

/// Neighbours whose normals differ more than this (cosine) are not of one surface.
constexpr float kSameSurface = 0.97f;
/// A pair is off the line when it is by more than this many standard errors of a + b - 2 c.
constexpr float kDeviations = 2.0f;

/// Texels apart in the last pass.
constexpr int kFarthest = 8;

float square(float v) { return v * v; }
float brightness(const GatheredTexel& t) { return t.irradiance.sum() / 3; }

/// What one pass makes of a texel.
struct Smoothed {
  Rgb irradiance;
  float variance = 0;
  std::array<std::uint32_t, 8> with{};  // texels that the mean is over, itself apart
  std::size_t count = 0;
};

Smoothed smooth_one(const atlas::Layout& layout, const atlas::TexelMap& map,
                    const std::vector<GatheredTexel>& texels, std::uint32_t t, int step,
                    float nearest) {
  const GatheredTexel& own = texels[t];
  Smoothed result{own.irradiance, own.variance, {}, 0};
  if (!own.gathered || own.distance < nearest) return result;
  const auto at = neighbourhood(map, layout, t, step);
  // A variance from two halves is rough; the neighbourhood's, as a share of the light there, is
  // steadier and stays small for a dark texel beside bright ones.
  float variance = 0, squares = 0;
  for (const std::uint32_t n : at) {
    if (n == scene::kNone || !texels[n].gathered) continue;
    variance += texels[n].variance;
    squares += square(brightness(texels[n]));
  }
  if (!(squares > 0)) return result;
  const float relative = variance / squares;
  Rgb sum = own.irradiance;
  float weight = 1, variances = own.variance;
  for (std::size_t k = 0; k < 4; ++k) {
    if (at[k] == scene::kNone || at[8 - k] == scene::kNone) continue;
    const GatheredTexel& a = texels[at[k]];
    const GatheredTexel& b = texels[at[8 - k]];
    const auto apart = [&](const GatheredTexel& n) {
      if (n.covered != own.covered) return true;
      if (!n.gathered) return step > 1;
      return n.distance < nearest || dot(n.normal, own.normal) < kSameSurface;
    };
    if (apart(a) || apart(b)) continue;
    const Rgb bend = a.irradiance + b.irradiance - own.irradiance * 2;
    const float expected =
        square(brightness(a)) + square(brightness(b)) + 4 * square(brightness(own));
    if (square(bend.sum() / 3) > square(kDeviations) * relative * expected) continue;
    sum += a.irradiance + b.irradiance;
    variances += a.variance + b.variance;
    weight += 2;
    result.with[result.count++] = at[k];
    result.with[result.count++] = at[8 - k];
  }
  result.irradiance = sum * (1 / weight);
  result.variance = variances / square(weight);
  return result;
}

}  // namespace

void smooth_gathered(const atlas::Layout& layout, const atlas::TexelMap& map, double reach,
                     std::vector<GatheredTexel>& texels, radiosity::GroupedLight& by_group) {
  std::vector<Smoothed> smooth(texels.size());
  radiosity::GroupedLight smooth_by_group = by_group;
  for (int step = 1; step <= kFarthest; step *= 2) {
    const double apart = step / layout.texels_per_metre;
    const float nearest = step > 1 ? static_cast<float>(apart / reach) : 0;
    parallel_for(texels.size(), 512, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        smooth[i] = smooth_one(layout, map, texels, static_cast<std::uint32_t>(i), step, nearest);
        for (std::size_t g = 0; g < by_group.groups(); ++g) {
          Rgb sum = by_group.of(i)[g];
          for (std::size_t k = 0; k < smooth[i].count; ++k) {
            sum += by_group.of(smooth[i].with[k])[g];
          }
          smooth_by_group.of(i)[g] = sum * (1 / static_cast<float>(1 + smooth[i].count));
        }
      }
    });
    for (std::size_t i = 0; i < texels.size(); ++i) {
      texels[i].irradiance = smooth[i].irradiance;
      texels[i].variance = smooth[i].variance;
    }
    by_group = smooth_by_group;
  }
}

}  // namespace lightbatch::lightmap
