// Direct light of every texel. Every texel gets a pilot: a few shadow rays to the emitters and one
// to each punctual light (a few where there are few lights, and at the border of a chart, where a
// neighbour that would tell of an edge is missing). Where the pilot is mixed, or differs from that
// of one of the eight neighbours in the chart, the texel is refined with many more; the neighbour
// test is what finds thin penumbrae.

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/parallel.h"
#include "core/lightmap/bake.h"
#include "core/lightmap/direct_texel.h"
#include "core/lightmap/neighbours.h"
#include "core/scene/scene.h"

namespace lightbatch::lightmap {
namespace {

constexpr std::size_t kGrain = 256;
/// Up to so many punctual lights, all pilots ask them from several points.
constexpr std::size_t kFewLights = 8;

/// What is to be refined of a texel.
struct Refine {
  bool emitters = false;
  bool punctual = false;
};

Refine what_to_refine(const atlas::TexelMap& map, const atlas::Layout& layout,
                      const std::vector<DirectPilot>& pilots, std::uint32_t t) {
  const DirectPilot& own = pilots[t];
  Refine refine{own.emitters == DirectPilot::kMixed, own.punctual_mixed};
  for (const std::uint32_t other : neighbourhood(map, layout, t)) {
    if (other == scene::kNone || !pilots[other].measured) continue;
    const DirectPilot& pilot = pilots[other];
    refine.emitters =
        refine.emitters || pilot.emitters == DirectPilot::kMixed || pilot.emitters != own.emitters;
    refine.punctual = refine.punctual || pilot.punctual_mixed || pilot.punctual != own.punctual;
  }
  return refine;
}

/// Visible share of the emitters, per channel mean.
float visible_share(const EmitterPart& p) {
  return p.open.sum() > 0 ? p.arrives.sum() / p.open.sum() : 0;
}

/// Evens out the noise of visibility between refined neighbours: the share becomes the mean over
/// opposite pairs of neighbours (which keeps gradients), where all differ by no more than noise of
/// the samples explains; edges sharper than that stay as they are.
/// The factor of what arrives, per texel.
std::vector<float> smooth_visibility(const BakeInput& input, const std::vector<EmitterPart>& parts,
                                     const std::vector<Refine>& refine) {
  std::vector<float> factor(parts.size(), 1.0f);
  parallel_for(parts.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto t = static_cast<std::uint32_t>(i);
      const float own = visible_share(parts[t]);
      if (!refine[t].emitters || !(own > 0)) continue;
      const auto at = neighbourhood(input.texels, input.layout, t);
      float sum = own, weight = 1;
      const float slack = parts[t].slack;
      for (std::size_t k = 0; k < 4; ++k) {
        const std::uint32_t a = at[k], b = at[8 - k];
        if (a == scene::kNone || b == scene::kNone || !refine[a].emitters || !refine[b].emitters) {
          continue;
        }
        const float va = visible_share(parts[a]), vb = visible_share(parts[b]);
        if (std::fabs(va + vb - 2 * own) > 2 * slack || std::fabs(va - vb) > 6 * slack) continue;
        sum += va + vb;
        weight += 2;
      }
      factor[t] = sum / weight / own;
    }
  });
  return factor;
}

}  // namespace

std::vector<Rgb> bake_direct(const BakeInput& input, const GatherSettings& settings,
                             radiosity::GroupedLight& by_group, BakeCounts& counts,
                             const Progress& progress) {
  const std::size_t count = input.texels.texels.size();
  std::vector<Rgb> direct(count);
  if (!input.direct_lights || count == 0) return direct;
  const DirectTexel measure(input, settings);
  const bool few_lights = input.direct.sources().punctual().size() <= kFewLights;
  std::vector<DirectPilot> pilots(count);
  std::vector<EmitterPart> emitters(count);
  radiosity::GroupedLight of_emitters(by_group.is_empty() ? 0 : count, by_group.groups());
  radiosity::GroupedLight of_punctual = of_emitters;
  std::vector<BakeCounts> block((count + kGrain - 1) / kGrain);
  const auto for_texels = [&](const auto& visit) {
    parallel_for(count, kGrain, [&](std::size_t begin, std::size_t end) {
      if (progress.cancelled()) return;
      for (std::size_t t = begin; t < end; ++t) {
        if (input.selected != nullptr && (*input.selected)[t] == 0) continue;
        visit(static_cast<std::uint32_t>(t), block[begin / kGrain]);
      }
    });
  };
  for_texels([&](std::uint32_t t, BakeCounts& c) {
    const auto at = neighbourhood(input.texels, input.layout, t);
    const bool border = std::find(at.begin(), at.end(), scene::kNone) != at.end();
    pilots[t].thorough = border || few_lights;
    emitters[t] = measure.pilot_emitters(t, pilots[t], of_emitters.of(t), c);
    if (input.punctual_direct) {
      direct[t] = measure.pilot_punctual(t, pilots[t], of_punctual.of(t), c);
    }
  });
  std::vector<Refine> refine(count);
  for_texels([&](std::uint32_t t, BakeCounts& c) {
    refine[t] = what_to_refine(input.texels, input.layout, pilots, t);
    // Too weak to matter, whatever hides it: the pilot's answer is good enough.
    if (static_cast<double>(emitters[t].open.max()) <=
        settings.direct_error * input.mean_irradiance) {
      refine[t].emitters = false;
    }
    if (refine[t].emitters || refine[t].punctual) ++c.refined_texels;
    if (refine[t].emitters) {
      emitters[t] = measure.refined_emitters(t, emitters[t].open, of_emitters.of(t), c);
    }
    if (refine[t].punctual) direct[t] = measure.refined_punctual(t, of_punctual.of(t), c);
  });
  const std::vector<float> factor = smooth_visibility(input, emitters, refine);
  for (std::size_t t = 0; t < count; ++t) {
    direct[t] += emitters[t].arrives * factor[t];
    for (std::size_t g = 0; g < by_group.groups(); ++g) {
      by_group.of(t)[g] += of_punctual.of(t)[g] + of_emitters.of(t)[g] * factor[t];
    }
  }
  for (const BakeCounts& c : block) counts += c;
  return direct;
}

}  // namespace lightbatch::lightmap
