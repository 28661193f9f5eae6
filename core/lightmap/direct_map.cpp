// Direct light of every texel. Every texel gets a pilot: a shadow ray to each lamp that matters and
// to each punctual light (a few where there are few lights, and at the border of a chart, where a
// neighbour that would tell of an edge is missing). Where the pilot sees a lamp in part, or sees it
// otherwise than one of the eight neighbours in the chart, that lamp is asked many times more; the
// neighbour test is what finds thin penumbrae.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "core/base/parallel.h"
#include "core/lightmap/bake.h"
#include "core/lightmap/dim.h"
#include "core/lightmap/emitter_texel.h"
#include "core/lightmap/neighbours.h"
#include "core/lightmap/punctual_texel.h"
#include "core/scene/scene.h"

namespace lightbatch::lightmap {
namespace {

constexpr std::size_t kGrain = 256;
/// Up to so many punctual lights, all pilots ask them from several points.
constexpr std::size_t kFewLights = 8;

/// What the pilots say of all texels.
struct Pilots {
  explicit Pilots(std::size_t texels)
      : punctual(texels), emitters(texels), states(texels), measured(texels) {}
  std::vector<PunctualPilot> punctual;
  std::vector<EmitterPart> emitters;
  std::vector<std::vector<SourceState>> states;
  std::vector<std::uint8_t> measured;
};

bool refine_punctual(const Pilots& pilots, const std::array<std::uint32_t, 9>& around) {
  const PunctualPilot& own = pilots.punctual[around[4]];
  return std::any_of(around.begin(), around.end(), [&](std::uint32_t other) {
    if (other == scene::kNone || pilots.measured[other] == 0) return false;
    return pilots.punctual[other].mixed || pilots.punctual[other].states != own.states;
  });
}

std::vector<SourceState> states_around(const Pilots& pilots,
                                       const std::array<std::uint32_t, 9>& around) {
  std::array<std::span<const SourceState>, 9> others;
  std::transform(around.begin(), around.end(), others.begin(), [&](std::uint32_t other) {
    return other == scene::kNone ? std::span<const SourceState>() : pilots.states[other];
  });
  return doubtful_states(pilots.states[around[4]], others);
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
                                     const std::vector<std::uint8_t>& refined) {
  std::vector<float> factor(parts.size(), 1.0f);
  parallel_for(parts.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto t = static_cast<std::uint32_t>(i);
      const float own = visible_share(parts[t]);
      if (refined[t] == 0 || !(own > 0)) continue;
      const auto at = neighbourhood(input.texels, input.layout, t);
      float sum = own, weight = 1;
      const float slack = parts[t].slack;
      for (std::size_t k = 0; k < 4; ++k) {
        const std::uint32_t a = at[k], b = at[8 - k];
        if (a == scene::kNone || b == scene::kNone || refined[a] == 0 || refined[b] == 0) continue;
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
                             const DimShares& dim, radiosity::GroupedLight& by_group,
                             BakeCounts& counts, const Progress& progress, double* seconds) {
  const std::size_t count = input.texels.texels.size();
  std::vector<Rgb> direct(count);
  if (!input.direct_lights || count == 0) return direct;
  const PunctualTexel punctual(input, settings);
  const auto& lights = input.direct.sources().punctual();
  const bool few_lights = lights.size() <= kFewLights;
  const bool any_punctual =
      std::any_of(lights.begin(), lights.end(),
                  [&](const radiosity::PunctualLight& light) { return input.bakes_direct(light); });
  const bool any_emitters = !input.direct.sources().emitters().empty();
  Pilots pilots(count);
  std::vector<EmitterPart>& emitters = pilots.emitters;
  radiosity::GroupedLight of_emitters(by_group.is_empty() ? 0 : count, by_group.groups());
  radiosity::GroupedLight of_punctual = of_emitters;
  std::vector<BakeCounts> block((count + kGrain - 1) / kGrain);
  const auto for_texels = [&](const auto& visit) {
    const auto began = std::chrono::steady_clock::now();
    parallel_for(count, kGrain, [&](std::size_t begin, std::size_t end) {
      if (progress.cancelled()) return;
      EmitterTexel emitter(input, settings);
      for (std::size_t t = begin; t < end; ++t) {
        if (input.selected != nullptr && (*input.selected)[t] == 0) continue;
        const auto texel = static_cast<std::uint32_t>(t);
        visit(texel, neighbourhood(input.texels, input.layout, texel), emitter,
              block[begin / kGrain]);
      }
    });
    if (seconds == nullptr) return;
    *seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  };
  for_texels([&](std::uint32_t t, const auto& around, EmitterTexel& emitter, BakeCounts& c) {
    const bool border = std::find(around.begin(), around.end(), scene::kNone) != around.end();
    pilots.measured[t] = 1;
    if (any_emitters) {
      emitter.allow(dim.at(t));
      emitters[t] = emitter.pilot(t, border, pilots.states[t], of_emitters.of(t), c);
    }
    if (any_punctual) {
      pilots.punctual[t].thorough = border || few_lights;
      direct[t] = punctual.pilot(t, dim.at(t), pilots.punctual[t], of_punctual.of(t), c);
    }
  });
  std::vector<std::uint8_t> refined(count);
  for_texels([&](std::uint32_t t, const auto& around, EmitterTexel& emitter, BakeCounts& c) {
    const double share = dim.at(t, direct[t] + emitters[t].arrives);
    if (any_emitters) {
      emitter.allow(share);
      const std::vector<SourceState> states = states_around(pilots, around);
      refined[t] = emitter.is_to_be_refined(emitters[t], states) ? 1 : 0;
      if (refined[t] != 0) {
        emitters[t] = emitter.refined(t, emitters[t], states, of_emitters.of(t), c);
      }
    }
    const bool again = refine_punctual(pilots, around);
    if (again) direct[t] = punctual.refined(t, share, of_punctual.of(t), c);
    if (again || refined[t] != 0) ++c.refined_texels;
  });
  const std::vector<float> factor = smooth_visibility(input, emitters, refined);
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
