#include "core/lightmap/punctual_texel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/random.h"
#include "core/lightmap/edge_samples.h"
#include "core/math/sobol.h"

namespace lightbatch::lightmap {
namespace {

using radiosity::PunctualLight;
using radiosity::Receiver;

/// Error of visibility, as in edge_samples.h, where N samples go to each sixteenth of a texel that
/// the edge touches: about five of them, each a sixteenth of the whole.
constexpr double kSixteenthsError = kEdgeError * 2.24 / 16;
constexpr int kMostEdgeRounds = 1024;
/// Rays from every sixteenth of a refined texel, before it is known where edges run: at least and
/// at most, and the share of an edge's allowed error that one ray's sixteenth may bring.
constexpr std::uint32_t kFirstRounds = 4;
constexpr double kMostFirstRounds = 64;
constexpr double kUnseenShare = 2;
/// A light that is so many times the mean irradiance is asked from all points of a texel: a strip
/// of sun that is thinner than a texel counts.
constexpr double kStrong = 2;
/// Shares of a light that differ by more than this are two states.
constexpr float kSameShare = 0.02f;

/// What one sixteenth of a texel sees of one light.
struct Sixteenth {
  Rgbd sum;
  float lowest = 1, highest = 0;  // shares
  std::uint32_t taken = 0;
  bool mixed() const { return highest - lowest > kSameShare; }
  float middle() const { return 0.5f * (lowest + highest); }
};

bool adjacent(const TexelPoints::Point& a, const TexelPoints::Point& b) {
  constexpr float kNext = 0.3f;  // a sixteenth is a quarter of a texel across
  return std::fabs(a.at.x - b.at.x) < kNext && std::fabs(a.at.y - b.at.y) < kNext;
}

}  // namespace

PunctualTexel::PunctualTexel(const BakeInput& input, const GatherSettings& settings)
    : input_(input),
      settings_(settings),
      allowed_(settings.direct_error * input.mean_irradiance),
      lights_(input.direct.sources().punctual()) {}

Rgb PunctualTexel::pilot(std::uint32_t t, PunctualPilot& pilot, std::span<Rgb> by_group,
                         BakeCounts& counts) const {
  Rgbd sum;
  std::fill(by_group.begin(), by_group.end(), Rgb{});
  if (lights_.empty()) return {};
  const atlas::Texel& texel = input_.texels.texels[t];
  const TexelPoints points = texel_points(input_.texels, texel);
  const std::uint32_t used =
      std::min(points.count, static_cast<std::uint32_t>(std::clamp(settings_.pilot_rays, 1, 16)));
  const float lift = input_.direct.lift();
  const Receiver centre =
      receiver_at(input_.scene, input_.layout, central_point(input_.texels, texel), lift);
  Receivers receivers(input_.scene, input_.layout, lift);
  std::array<Receiver, 16> at;
  for (std::uint32_t i = 0; i < used; ++i) at[i] = receivers(points.point[i], {0.5f, 0.5f});
  std::uint32_t hash = 1;
  for (const PunctualLight& light : lights_) {
    Rgbd open;
    float least = std::numeric_limits<float>::infinity(), most = 0;
    for (std::uint32_t i = 0; i < used; ++i) {
      const Rgb value = light.irradiance(at[i].frame.position, at[i].frame.normal);
      least = std::min(least, value.max());
      most = std::max(most, value.max());
      open += to_double(value);
    }
    if (open.is_black()) {
      hash = hash * 0x9e3779b1u + 1;
      continue;
    }
    // The edge of a cone or of a range, a lamp close by, a sheet's edge, a shadow's edge.
    const Rgb share = input_.direct.punctual_visibility(centre, light, counts.rays);
    const bool uneven = static_cast<double>(most - least) > kMostUneven * allowed_;
    bool mixed = least == 0 || (!share.is_black() && (uneven || !(share == Rgb{1, 1, 1})));
    for (std::uint32_t i = 0; pilot.thorough && i < used && !mixed; ++i) {
      mixed = !(input_.direct.punctual_visibility(at[i], light, counts.rays) == share);
    }
    if (pilot.thorough && !mixed && open.sum() > 3 * kStrong * used * input_.mean_irradiance) {
      const OwenSobol2 within(static_cast<std::uint32_t>(item_seed(input_.seed, t, 290)));
      for (std::uint32_t i = 0; i < points.count && !mixed; ++i) {
        const Receiver near = receivers(points.point[i], within.point(i));
        mixed = !(input_.direct.punctual_visibility(near, light, counts.rays) == share);
      }
    }
    pilot.mixed = pilot.mixed || mixed;
    hash = hash * 0x9e3779b1u + (share.is_black() ? 2 : 3);
    const Rgbd arrives = open * to_double(share);
    sum += arrives;
    if (!by_group.empty()) by_group[light.group] += to_float(arrives / static_cast<double>(used));
  }
  pilot.states = hash;
  return to_float(sum / static_cast<double>(used));
}

Rgbd PunctualTexel::one_light(std::uint32_t t, std::size_t l, const TexelPoints& points,
                              BakeCounts& counts) const {
  const PunctualLight& light = lights_[l];
  Receivers receivers(input_.scene, input_.layout, input_.direct.lift());
  std::array<Sixteenth, 16> part;
  double open_sum = 0;
  const auto take = [&](std::uint32_t i, std::uint32_t begin, std::uint32_t end) {
    const OwenSobol2 shift(static_cast<std::uint32_t>(item_seed(input_.seed, t, 300 + 16 * l + i)));
    for (std::uint32_t round = begin; round < end; ++round) {
      const Receiver at = receivers(points.point[i], shift.point(round));
      const Rgb open = light.irradiance(at.frame.position, at.frame.normal);
      const Rgb share =
          open.is_black() ? Rgb{} : input_.direct.punctual_visibility(at, light, counts.rays);
      const float seen = share.sum() / 3;
      part[i].lowest = std::min(part[i].lowest, seen);
      part[i].highest = std::max(part[i].highest, seen);
      part[i].sum += to_double(open * share);
      ++part[i].taken;
      open_sum = std::max(open_sum, static_cast<double>(open.max()));
    }
  };
  for (std::uint32_t i = 0; i < points.count; ++i) take(i, 0, kFirstRounds);
  // A strip that covers less of a sixteenth than one ray stands for may pass unseen.
  const double allowed = kUnseenShare * allowed_;
  const auto first_rounds = static_cast<std::uint32_t>(std::clamp(
      allowed > 0 ? open_sum / (16 * allowed) : 0, double{kFirstRounds}, kMostFirstRounds));
  for (std::uint32_t i = 0; i < points.count; ++i) take(i, kFirstRounds, first_rounds);
  std::array<bool, 16> edge{};
  for (std::uint32_t i = 0; i < points.count; ++i) {
    edge[i] = part[i].mixed();
    for (std::uint32_t j = 0; j < points.count && !edge[i]; ++j) {
      edge[i] = adjacent(points.point[i], points.point[j]) &&
                (part[j].mixed() || std::fabs(part[i].middle() - part[j].middle()) > kSameShare);
    }
  }
  const auto rounds = static_cast<std::uint32_t>(
      samples_for_edge(open_sum, allowed_, kSixteenthsError, kMostEdgeRounds));
  Rgbd total;
  for (std::uint32_t i = 0; i < points.count; ++i) {
    if (edge[i] && rounds > first_rounds) take(i, first_rounds, rounds);
    total += part[i].sum / static_cast<double>(part[i].taken);
  }
  return total / static_cast<double>(points.count);
}

Rgb PunctualTexel::refined(std::uint32_t t, std::span<Rgb> by_group, BakeCounts& counts) const {
  std::fill(by_group.begin(), by_group.end(), Rgb{});
  const TexelPoints points = texel_points(input_.texels, input_.texels.texels[t]);
  Rgbd total;
  for (std::size_t l = 0; l < lights_.size(); ++l) {
    const Rgbd arrives = one_light(t, l, points, counts);
    total += arrives;
    if (!by_group.empty()) by_group[lights_[l].group] += to_float(arrives);
  }
  return to_float(total);
}

}  // namespace lightbatch::lightmap
