#include "core/lightmap/emitter_texel.h"

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/lightmap/edge_samples.h"
#include "core/math/sobol.h"

namespace lightbatch::lightmap {
namespace {

using radiosity::Receiver;
using radiosity::VisibilitySum;

/// Of the allowed error: a source that is not worth a ray of its own.
constexpr double kNegligible = 0.3;
constexpr int kFewestEdgeRays = 4;
constexpr int kMostEdgeRays = 4096;
/// Rays to a source where no neighbour tells of an edge.
constexpr int kThoroughRays = 4;
constexpr int kMostPilotRays = 64;
/// Pilot rays to a source, of its light over the allowed error.
constexpr double kUnseen = 0.06;
/// Points of a refined texel: at least, at most, and for a range of open light as large as the
/// allowed error.
constexpr double kEdgePoints = 16;
constexpr double kMostPoints = 256;
constexpr double kPointsForUneven = 2;

const SourceState* find(std::span<const SourceState> states, std::uint32_t source) {
  const auto at = std::lower_bound(
      states.begin(), states.end(), source,
      [](const SourceState& s, std::uint32_t wanted) { return s.source < wanted; });
  return at != states.end() && at->source == source ? &*at : nullptr;
}

}  // namespace

std::vector<SourceState> doubtful_states(std::span<const SourceState> own,
                                         std::span<const std::span<const SourceState>> neighbours) {
  std::vector<SourceState> states(own.begin(), own.end());
  for (const auto& other : neighbours) {
    auto theirs = other.begin();
    for (SourceState& s : states) {
      while (theirs != other.end() && theirs->source < s.source) ++theirs;
      if (theirs != other.end() && theirs->source == s.source && theirs->state != s.state) {
        s.state = SourceState::kMixed;
      }
    }
  }
  return states;
}

/// What the sources of a texel add up to.
struct EmitterTexel::Sums {
  Rgbd arrives, open;
  double variance = 0;  // lux^2
};

EmitterTexel::EmitterTexel(const BakeInput& input, const GatherSettings& settings)
    : input_(input),
      settings_(settings),
      receivers_(input.scene, input.layout, input.direct.lift()),
      allowed_(settings.direct_error * input.mean_irradiance),
      negligible_(kNegligible * allowed_) {}

int EmitterTexel::rays_for_edge(double light, std::size_t edges) const {
  const double each = allowed_ / std::sqrt(static_cast<double>(std::max<std::size_t>(1, edges)));
  return std::max(kFewestEdgeRays, samples_for_edge(light, each, kEdgeError, kMostEdgeRays));
}

Receiver EmitterTexel::receiver(std::uint32_t i, Vec2f within) {
  return receivers_(grid_.point[i % grid_.count], within);
}

/// Terms at `points` points of the texel, by source.
void EmitterTexel::collect(std::uint32_t t, std::uint32_t points, BakeCounts& counts) {
  grid_ = texel_points(input_.texels, input_.texels.texels[t]);
  const std::uint32_t used = points < grid_.count ? points : points - points % grid_.count;
  const OwenSobol2 within(static_cast<std::uint32_t>(item_seed(input_.seed, t, 201)));
  points_ = used;
  records_.clear();
  for (std::uint32_t i = 0; i < used; ++i) {
    const Receiver at = receiver(i, i < grid_.count ? Vec2f{0.5f, 0.5f} : within.point(i));
    const float turn = static_cast<float>(i) / static_cast<float>(used);
    input_.direct.emitter_terms(at, {item_seed(input_.seed, t, 200), turn}, terms_, counts.rays,
                                static_cast<float>(negligible_));
    for (std::size_t k = 0; k < terms_.count; ++k) records_.push_back({terms_.term[k], i});
  }
  std::sort(records_.begin(), records_.end(), [](const Record& a, const Record& b) {
    if (a.term.source != b.term.source) return a.term.source < b.term.source;
    return a.term.emitter != b.term.emitter ? a.term.emitter < b.term.emitter : a.point < b.point;
  });
}

VisibilitySum EmitterTexel::cast(std::uint32_t t, std::span<const Record> records, int rays,
                                 BakeCounts& counts) {
  up_to_.clear();
  float weight = 0;
  for (const Record& r : records) up_to_.push_back(weight += r.term.weight);
  const OwenSobol8 sequence(
      static_cast<std::uint32_t>(item_seed(input_.seed, t, 1000 + records[0].term.source)));
  VisibilitySum sum;
  // Points of an emitter that lie behind the texel make no ray.
  for (std::uint32_t k = 0; sum.rays < rays && k < 4 * static_cast<std::uint32_t>(rays); ++k) {
    const auto chosen =
        std::upper_bound(up_to_.begin(), up_to_.end() - 1, sequence.coordinate(k, 2) * weight);
    const Record& r = records[static_cast<std::size_t>(chosen - up_to_.begin())];
    input_.direct.emitter_ray(receiver(r.point, sequence.pair(k, 3)), r.term,
                              static_cast<double>(r.term.weight / weight), sequence.pair(k, 0),
                              counts.rays, sum);
  }
  return sum;
}

EmitterPart EmitterTexel::measure(std::uint32_t t, int fewest_rays,
                                  std::span<const SourceState> known,
                                  std::vector<SourceState>* states, std::span<Rgb> by_group,
                                  BakeCounts& counts) {
  std::fill(by_group.begin(), by_group.end(), Rgb{});
  if (records_.empty()) return {};
  const auto scale = static_cast<float>(1.0 / points_);
  const auto edges = static_cast<std::size_t>(std::count_if(
      known.begin(), known.end(), [](const auto& s) { return s.state == SourceState::kMixed; }));
  double total = 0;
  for (const Record& r : records_) total += static_cast<double>(r.term.weight * scale) / 3;
  Sums sums;
  light_at_.assign(points_, 0.0f);
  const auto settle = [&](std::span<const Record> run, const Rgb& share) {
    for (const Record& r : run) {
      const Rgb open = r.term.irradiance * scale;
      sums.open += to_double(open);
      sums.arrives += to_double(open * share);
      light_at_[r.point] += (r.term.irradiance * share).sum() / 3;
      if (by_group.empty()) continue;
      by_group[input_.direct.sources().emitters()[r.term.emitter].group] += open * share;
    }
  };
  const auto take = [&](std::span<const Record> run, double light, const VisibilitySum& seen) {
    settle(run, seen.share());
    const double doubt =
        seen.none() || seen.full() ? 0 : light * edge_error(std::max(1, seen.rays));
    sums.variance += doubt * doubt;
  };
  weak_.clear();
  double weak_light = 0;
  for (std::size_t begin = 0, end = 0; begin < records_.size(); begin = end) {
    const std::uint32_t source = records_[begin].term.source;
    double light = 0;
    for (; end < records_.size() && records_[end].term.source == source; ++end) {
      light += static_cast<double>(records_[end].term.weight * scale) / 3;
    }
    const auto run = std::span<const Record>(records_).subspan(begin, end - begin);
    const SourceState* state = find(known, source);
    if (state != nullptr && state->state != SourceState::kMixed) {
      settle(run, state->state == SourceState::kLit ? Rgb{1, 1, 1} : Rgb{});
      continue;
    }
    if (light < negligible_) {
      weak_.insert(weak_.end(), run.begin(), run.end());
      weak_light += light;
      continue;
    }
    // A source that is seen by a small part may pass for dark: the more it would bring, the more
    // rays, shared with the neighbours' where there are some.
    const double worth = allowed_ > 0 ? kUnseen * light / allowed_ * fewest_rays : kMostPilotRays;
    const double share = settings_.pilot_rays * light / total;
    const int few =
        std::clamp(static_cast<int>(std::max(share, worth) + 0.5), fewest_rays, kMostPilotRays);
    const int rays = state != nullptr ? std::max(few, rays_for_edge(light, edges)) : few;
    const VisibilitySum seen = cast(t, run, rays, counts);
    take(run, light, seen);
    if (states == nullptr) continue;
    states->push_back({source & 0x3fffffffu, seen.full()   ? SourceState::kLit
                                             : seen.none() ? SourceState::kDark
                                                           : SourceState::kMixed});
  }
  if (!weak_.empty()) {
    // Many weak sources together: asked at once as often as it takes.
    const double rays = negligible_ > 0 ? weak_light / negligible_ : kMostPilotRays;
    VisibilitySum seen =
        cast(t, weak_, std::clamp(static_cast<int>(rays), fewest_rays, kMostPilotRays), counts);
    const int wanted = rays_for_edge(weak_light, edges + 1);
    if (!seen.none() && !seen.full() && wanted > seen.rays) seen = cast(t, weak_, wanted, counts);
    take(weak_, weak_light, seen);
  }
  EmitterPart part;
  part.arrives = to_float(sums.arrives);
  part.open = to_float(sums.open);
  if (total > 0) part.slack = static_cast<float>(3 * std::sqrt(sums.variance) / total);
  const auto [least, most] = std::minmax_element(light_at_.begin(), light_at_.end());
  part.uneven = *most - *least;
  return part;
}

EmitterPart EmitterTexel::pilot(std::uint32_t t, bool thorough, std::vector<SourceState>& states,
                                std::span<Rgb> by_group, BakeCounts& counts) {
  const int rays = std::clamp(settings_.pilot_rays, kThoroughRays, 16);
  collect(t, static_cast<std::uint32_t>(rays), counts);
  states.clear();
  const int fewest = thorough ? rays : std::max(1, rays / kThoroughRays);
  return measure(t, fewest, {}, &states, by_group, counts);
}

bool EmitterTexel::is_to_be_refined(const EmitterPart& pilot,
                                    std::span<const SourceState> states) const {
  if (static_cast<double>(pilot.uneven) > kMostUneven * allowed_) return true;
  // Too weak to matter, whatever hides it: the pilot's answer is good enough.
  if (static_cast<double>(pilot.open.max()) <= allowed_) return false;
  return std::any_of(states.begin(), states.end(),
                     [](const auto& s) { return s.state == SourceState::kMixed; });
}

EmitterPart EmitterTexel::refined(std::uint32_t t, const EmitterPart& pilot,
                                  std::span<const SourceState> states, std::span<Rgb> by_group,
                                  BakeCounts& counts) {
  const double points =
      allowed_ > 0 ? kPointsForUneven * static_cast<double>(pilot.uneven) / allowed_ : 0;
  collect(t, static_cast<std::uint32_t>(std::clamp(points, kEdgePoints, kMostPoints)), counts);
  return measure(t, kThoroughRays, states, nullptr, by_group, counts);
}

}  // namespace lightbatch::lightmap
