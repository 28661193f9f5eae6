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
/// Texel edges within which emitters are close: cells of a texel are measured for them alone.
constexpr double kReach = 1;
/// Cells of a texel with uneven light, at most, and what they may be off by, of the allowed error.
constexpr std::size_t kMostCells = 256;
constexpr double kUnevenShare = 0.1;

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
      receivers_(input.scene, input.layout, input.direct.lift()) {
  allow(1);
}

void EmitterTexel::allow(double share) {
  allowed_ = share * settings_.direct_error * input_.mean_irradiance;
  negligible_ = kNegligible * allowed_;
}

int EmitterTexel::rays_for_edge(double light, std::size_t edges) const {
  const double each = allowed_ / std::sqrt(static_cast<double>(std::max<std::size_t>(1, edges)));
  return std::max(kFewestEdgeRays, samples_for_edge(light, each, kEdgeError, kMostEdgeRays));
}

Receiver EmitterTexel::receiver(const Cell& cell, Vec2f within) {
  return receivers_(grid_.point[cell.point], cell.low + within * cell.edge);
}

void EmitterTexel::add_record(radiosity::EmitterTerms::Term term, std::uint32_t cell) {
  term.scale_by(cells_[cell].share);
  records_.push_back({term, cell});
}

void EmitterTexel::add_terms(std::uint32_t t, std::uint32_t cell, float turn, BakeCounts& counts) {
  Cell& c = cells_[cell];
  const Receiver middle = receiver(c, {0.5f, 0.5f});
  input_.direct.emitter_terms(middle, {item_seed(input_.seed, t, 200), turn}, terms_, counts.rays,
                              static_cast<float>(negligible_),
                              static_cast<float>(kReach / input_.layout.texels_per_metre));
  c.light = terms_.weight;
  for (std::size_t k = 0; k < terms_.count; ++k) {
    if (!terms_.term[k].close) c.far += terms_.term[k].weight;
    add_record(terms_.term[k], cell);
  }
  close_.insert(close_.end(), terms_.close.begin(), terms_.close.begin() + terms_.close_count);
  close_begin_.push_back(static_cast<std::uint32_t>(close_.size()));
  c.most = most_of_close(c, middle);
}

void EmitterTexel::add_close_terms(std::uint32_t cell, BakeCounts& counts) {
  Cell& c = cells_[cell];
  const Receiver middle = receiver(c, {0.5f, 0.5f});
  c.light = c.far;
  for (const std::uint32_t emitter : close_to(c)) {
    auto term = input_.direct.emitter_term(middle, emitter, counts.rays);
    if (term.irradiance.is_black()) continue;
    term.close = true;
    c.light += term.weight;
    add_record(term, cell);
  }
  c.most = most_of_close(c, middle);
}

std::span<const std::uint32_t> EmitterTexel::close_to(const Cell& cell) const {
  return std::span(close_).subspan(close_begin_[cell.point],
                                   close_begin_[cell.point + 1] - close_begin_[cell.point]);
}

float EmitterTexel::most_of_close(const Cell& cell, const Receiver& middle) const {
  const double edge = std::sqrt(static_cast<double>(cell.share)) / input_.layout.texels_per_metre;
  float most = 0;
  for (const std::uint32_t emitter : close_to(cell)) {
    most += input_.direct.most_nearby(emitter, middle, static_cast<float>(edge));
  }
  return most;
}

void EmitterTexel::start(std::uint32_t t, std::uint32_t points, BakeCounts& counts) {
  grid_ = texel_points(input_.texels, input_.texels.texels[t]);
  const std::uint32_t used = std::min(points, grid_.count);
  const float share = 1 / static_cast<float>(used);
  cells_.clear();
  records_.clear();
  close_.clear();
  close_begin_.assign(1, 0);
  for (std::uint32_t i = 0; i < used; ++i) {
    cells_.push_back({i, {0, 0}, 1, share});
    add_terms(t, i, static_cast<float>(i) * share, counts);
  }
}

void EmitterTexel::cut(BakeCounts& counts) {
  // How far a cell's middle is off its mean: of what it differs from cells beside it by.
  constexpr float kOfDifference = 0.25f, kOfSiblings = 0.05f, kOfMost = 0.25f;
  const auto doubtful = [&](std::uint32_t a, std::uint32_t b) {
    return cells_[a].doubt != cells_[b].doubt ? cells_[a].doubt < cells_[b].doubt : a > b;
  };
  std::vector<std::uint32_t> heap;
  double doubt = 0;
  const auto add = [&](std::uint32_t cell) {
    doubt += static_cast<double>(cells_[cell].doubt);
    heap.push_back(cell);
    std::push_heap(heap.begin(), heap.end(), doubtful);
  };
  for (std::uint32_t i = 0; i < grid_.count; ++i) {
    float most = 0;
    for (std::uint32_t j = 0; j < grid_.count; ++j) {
      if (!adjacent(grid_.point[i], grid_.point[j])) continue;
      most = std::max(most, std::fabs(cells_[i].light - cells_[j].light));
    }
    cells_[i].doubt = cells_[i].share * (kOfDifference * most + kOfMost * cells_[i].unseen());
  }
  for (std::uint32_t i = 0; i < grid_.count; ++i) add(i);
  const double enough = 3 * kUnevenShare * allowed_;  // over channels
  while (doubt > enough && heap.size() + 3 <= kMostCells) {
    std::pop_heap(heap.begin(), heap.end(), doubtful);
    cells_[heap.back()].cut = true;
    const Cell whole = cells_[heap.back()];
    heap.pop_back();
    doubt -= static_cast<double>(whole.doubt);
    const auto first = static_cast<std::uint32_t>(cells_.size());
    float mean = 0;
    for (std::uint32_t k = 0; k < 4; ++k) {
      Cell part = whole;
      part.cut = false;
      part.edge = whole.edge / 2;
      part.share = whole.share / 4;
      part.low =
          whole.low + Vec2f{static_cast<float>(k & 1u), static_cast<float>(k >> 1)} * part.edge;
      cells_.push_back(part);
      add_close_terms(first + k, counts);
      mean += cells_[first + k].light / 4;
    }
    for (std::uint32_t k = 0; k < 4; ++k) {
      Cell& part = cells_[first + k];
      part.doubt =
          part.share * (kOfDifference * std::fabs(mean - whole.light) +
                        kOfSiblings * std::fabs(part.light - mean) + kOfMost * part.unseen());
      add(first + k);
    }
  }
  std::erase_if(records_, [&](const Record& r) { return r.term.close && cells_[r.cell].cut; });
}

void EmitterTexel::sort_records() {
  std::sort(records_.begin(), records_.end(), [](const Record& a, const Record& b) {
    if (a.term.source != b.term.source) return a.term.source < b.term.source;
    return a.term.emitter != b.term.emitter ? a.term.emitter < b.term.emitter : a.cell < b.cell;
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
    input_.direct.emitter_ray(receiver(cells_[r.cell], sequence.pair(k, 3)), r.term,
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
  const auto edges = static_cast<std::size_t>(std::count_if(
      known.begin(), known.end(), [](const auto& s) { return s.state == SourceState::kMixed; }));
  double total = 0;
  for (const Record& r : records_) total += static_cast<double>(r.term.weight) / 3;
  Sums sums;
  light_at_.assign(cells_.size(), 0.0f);
  const auto settle = [&](std::span<const Record> run, const Rgb& share) {
    for (const Record& r : run) {
      const Rgb& open = r.term.irradiance;
      sums.open += to_double(open);
      sums.arrives += to_double(open * share);
      light_at_[r.cell] += (open * share).sum() / (3 * cells_[r.cell].share);
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
      light += static_cast<double>(records_[end].term.weight) / 3;
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
  start(t, static_cast<std::uint32_t>(rays), counts);
  sort_records();
  states.clear();
  const int fewest = thorough ? rays : std::max(1, rays / kThoroughRays);
  EmitterPart part = measure(t, fewest, {}, &states, by_group, counts);
  float unseen = 0;
  for (const Cell& c : cells_) unseen += c.share * c.unseen() / 3;
  part.uneven = std::max(part.uneven, unseen);
  return part;
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
  start(t, static_cast<std::uint32_t>(grid_.point.size()), counts);
  if (static_cast<double>(pilot.uneven) > kMostUneven * allowed_) cut(counts);
  sort_records();
  return measure(t, kThoroughRays, states, nullptr, by_group, counts);
}

}  // namespace lightbatch::lightmap
