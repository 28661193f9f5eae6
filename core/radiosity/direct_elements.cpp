// Direct light of the elements. Points are Owen-Sobol over each element; every punctual light
// costs one shadow ray a point where its unshadowed irradiance is not zero.

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/math/sampling.h"
#include "core/math/sobol.h"
#include "core/radiosity/element_rays.h"
#include "core/radiosity/solver.h"

namespace lightbatch::radiosity {
namespace {

/// The lights that bring most over a sample of the elements, strongest first.
std::vector<std::uint32_t> choose_resolved(const SolverInput& input) {
  const auto& lights = input.direct.sources().punctual();
  std::vector<double> brings(lights.size(), 0.0);
  const std::uint32_t count = input.elements.count();
  const std::uint32_t stride = std::max(1u, count / 512);
  for (ElementId e = 0; e < count; e += stride) {
    const ElementPoint p = input.elements.point(e, 0.5f, 0.5f);
    const auto frame =
        optics::surface_frame(input.scene, p.triangle, p.u, p.v, input.elements.is_back(e), 0.0f);
    for (std::size_t i = 0; i < lights.size(); ++i) {
      brings[i] += static_cast<double>(lights[i].irradiance(frame.position, frame.normal).sum()) *
                   static_cast<double>(input.elements.covered_area(e));
    }
  }
  std::vector<std::uint32_t> order(lights.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return brings[a] > brings[b]; });
  if (order.size() > kResolvedLights) order.resize(kResolvedLights);
  return order;
}

std::uint16_t with_state(std::uint16_t states, std::size_t k, LightState s) {
  const auto cleared = static_cast<unsigned>(states) & ~(3u << (2 * k));
  return static_cast<std::uint16_t>(cleared | (static_cast<unsigned>(s) << (2 * k)));
}

/// Shadow rays to emitters from each point of an element, where these are few and where not.
constexpr int kFewRays = 2;
constexpr int kManyRays = 4;
/// An element is one of many that a texel sees: chance among its lamps evens out.
constexpr float kRoughCut = 0.05f;

/// Emitters light an element unevenly where the standard deviation over its points is more than
/// this share of the mean, and, times its area, more than that share of all the light they send: a
/// ceiling above a lamp sends what falls beside it from where it is dark.
constexpr double kUneven = 0.4;
constexpr double kUnevenOfAll = 2e-4;

/// Samples of an element that the edge of a resolved light's shadow crosses, against others.
constexpr int kEdgeSamples = 8;

/// A few samples may miss an edge that runs through an element. Only a cell whose neighbours are
/// all of its own state is believed to be wholly lit or wholly dark; groups of small triangles,
/// which have no neighbours, only when dark.
void doubt_borders(const Elements& elements, Solution& solution) {
  const std::vector<std::uint16_t> measured = solution.light_state;
  for (ElementId e = 0; e < elements.count(); ++e) {
    std::array<ElementId, 8> around{};
    const std::size_t count = elements.is_cell(e) ? elements.neighbours(e, around.data()) : 0;
    for (std::size_t k = 0; k < solution.resolved.size(); ++k) {
      const LightState own = solution.state(e, k);
      bool sure = own == LightState::kDark || elements.is_cell(e);
      for (std::size_t i = 0; i < count; ++i) {
        sure = sure && ((measured[around[i]] >> (2 * k)) & 3u) == static_cast<unsigned>(own);
      }
      if (!sure) {
        solution.light_state[e] = with_state(solution.light_state[e], k, LightState::kMixed);
      }
    }
  }
}

}  // namespace

Solution measure_direct(const SolverInput& input, const SolverOptions& options,
                        const Progress& progress, GroupedLight* direct_by_group) {
  const Elements& elements = input.elements;
  const auto& lights = input.direct.sources().punctual();
  const bool emitters = !input.direct.sources().emitters().empty();
  const double sent = emitters ? static_cast<double>(input.direct.sources().power(0)) : 0;
  const bool few_emitters = input.direct.sources().emitters().size() <= kFewEmitters;
  Solution solution;
  solution.resolved = choose_resolved(input);
  solution.irradiance.resize(elements.count());
  solution.unresolved.resize(elements.count());
  if (!solution.resolved.empty()) solution.light_state.resize(elements.count());
  if (emitters) solution.uneven.resize(elements.count());
  std::vector<std::uint8_t> slot(lights.size(), kResolvedLights);
  for (std::size_t k = 0; k < solution.resolved.size(); ++k) {
    slot[solution.resolved[k]] = static_cast<std::uint8_t>(k);
  }
  if (direct_by_group != nullptr) {
    *direct_by_group = GroupedLight(elements.count(), input.groups);
    solution.unresolved_by_group = GroupedLight(elements.count(), input.groups);
  }
  constexpr std::size_t kGrain = 512;
  const std::size_t blocks = (elements.count() + kGrain - 1) / kGrain;
  std::vector<RayCounts> counts(blocks);
  parallel_for(elements.count(), kGrain, [&](std::size_t begin, std::size_t end) {
    if (progress.cancelled()) return;
    RayCounts& rays = counts[begin / kGrain];
    EmitterTerms terms;
    for (std::size_t i = begin; i < end; ++i) {
      const auto e = static_cast<ElementId>(i);
      const double edges =
          static_cast<double>(elements.area(e)) / (elements.edge() * elements.edge());
      const int samples = std::clamp(static_cast<int>(4.0 * edges * options.direct_samples), 2,
                                     std::max(2, options.direct_samples));
      const OwenSobol2 points(static_cast<std::uint32_t>(item_seed(options.seed, e, 1)));
      const OwenSobol2 suns(static_cast<std::uint32_t>(item_seed(options.seed, e, 4)));
      Rgbd resolved, rest, emitted;
      double square = 0;  // of what emitters bring to the points, all channels
      std::array<int, kResolvedLights> lit{}, dark{};
      std::array<Rgb, kMostGroups> resolved_part{}, rest_part{}, emitted_part{};
      const auto receiver = [&](int s) {
        return receiver_on(input.scene, elements, e, points.point(static_cast<std::uint32_t>(s)),
                           input.direct.lift());
      };
      const auto ask_lights = [&](int s, const Receiver& at, bool resolved_only) {
        const Vec2f on_sun = suns.point(static_cast<std::uint32_t>(s));
        for (std::size_t l = 0; l < lights.size(); ++l) {
          const std::uint8_t k = slot[l];
          if (resolved_only && k == kResolvedLights) continue;
          const Rgb open = lights[l].irradiance(at.frame.position, at.frame.normal);
          if (open.is_black()) {
            if (k < kResolvedLights) ++dark[k];
            continue;
          }
          const Rgb share = input.direct.punctual_visibility(at, lights[l], on_sun, rays);
          if (k < kResolvedLights) {
            resolved += to_double(open * share);
            resolved_part[lights[l].group] += open * share;
            share == Rgb{1, 1, 1} ? ++lit[k] : share.is_black() ? ++dark[k] : (++lit[k], ++dark[k]);
          } else {
            rest += to_double(open * share);
            rest_part[lights[l].group] += open * share;
          }
        }
      };
      for (int s = 0; s < samples; ++s) {
        const Receiver at = receiver(s);
        ask_lights(s, at, false);
        if (emitters) {
          const float turn = static_cast<float>(s) / static_cast<float>(samples);
          input.direct.emitter_terms(at, {item_seed(options.seed, e, 100), turn, kRoughCut}, terms,
                                     rays);
          if (terms.count > 0) {
            // The same for all points, so that their places in the sequence do not meet.
            const int rays_each = few_emitters ? kFewRays : kManyRays;
            GroupVisibility by_group;
            const VisibilitySum seen = input.direct.emitter_visibility(
                at, terms, rays_each, static_cast<std::uint32_t>(rays_each * s),
                static_cast<std::uint32_t>(item_seed(options.seed, e, 2)), rays,
                direct_by_group != nullptr ? &by_group : nullptr);
            const Rgb arrives = terms.total * seen.share();
            emitted += to_double(arrives);
            square += static_cast<double>(arrives.sum()) * static_cast<double>(arrives.sum());
            if (direct_by_group != nullptr) {
              input.direct.split_emitters(terms, seen.share(), by_group, 1,
                                          std::span(emitted_part).first(input.groups));
            }
          }
        }
      }
      // The edge of a strong light's shadow decides what the element sends on.
      int resolved_samples = samples;
      bool mixed = false;
      for (std::size_t k = 0; k < kResolvedLights; ++k)
        mixed = mixed || (lit[k] > 0 && dark[k] > 0);
      for (; mixed && resolved_samples < kEdgeSamples * samples; ++resolved_samples) {
        ask_lights(resolved_samples, receiver(resolved_samples), true);
      }
      const double scale = 1.0 / samples;
      const double resolved_scale = 1.0 / resolved_samples;
      const double mean = emitted.sum() * scale;
      const double deviation = std::sqrt(std::max(0.0, square * scale - mean * mean));
      const bool uneven =
          deviation > kUneven * mean &&
          deviation * static_cast<double>(elements.covered_area(e)) > kUnevenOfAll * sent;
      if (emitters) solution.uneven[e] = uneven ? 1 : 0;
      if (!uneven) {
        rest += emitted;
        emitted = {};
      }
      solution.unresolved[e] = to_float(rest * scale);
      solution.irradiance[e] = to_float(rest * scale + emitted * scale + resolved * resolved_scale);
      for (std::size_t g = 0; direct_by_group != nullptr && g < input.groups; ++g) {
        const Rgb all = rest_part[g] + emitted_part[g];
        solution.unresolved_by_group.of(e)[g] =
            (uneven ? rest_part[g] : all) * static_cast<float>(scale);
        direct_by_group->of(e)[g] =
            all * static_cast<float>(scale) + resolved_part[g] * static_cast<float>(resolved_scale);
      }
      std::uint16_t state = 0;
      for (std::size_t k = 0; k < solution.resolved.size(); ++k) {
        const LightState s = lit[k] > 0 && dark[k] > 0 ? LightState::kMixed
                             : lit[k] > 0              ? LightState::kLit
                                                       : LightState::kDark;
        state = with_state(state, k, s);
      }
      if (!solution.light_state.empty()) solution.light_state[e] = state;
    }
  });
  if (!solution.light_state.empty() && !progress.cancelled()) doubt_borders(elements, solution);
  for (const RayCounts& c : counts) solution.statistics.rays += c;
  return solution;
}

}  // namespace lightbatch::radiosity
