#include "core/lightmap/punctual_texel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/base/random.h"
#include "core/lightmap/edge_samples.h"
#include "core/lightmap/lamp_cells.h"
#include "core/math/sobol.h"

namespace lightbatch::lightmap {
namespace {

using radiosity::PunctualLight;
using radiosity::Receiver;

constexpr int kMostEdgeRounds = 1024;
/// Rays from every sixteenth of a refined texel, before it is known where edges run: at least and
/// at most, and the share of an edge's allowed error that one ray's sixteenth may bring.
constexpr std::uint32_t kFirstRounds = 4;
constexpr double kMostFirstRounds = 64;
constexpr double kUnseenShare = 2;
/// A light that is so many times the mean irradiance is searched for all over a texel: a strip of
/// sun that is thinner than a texel counts.
constexpr double kStrong = 2;
/// Rays of such a search: a share of a gathered texel's, within limits.
constexpr int kRaysOverSearch = 8;
constexpr int kMostSearched = 64;
/// Shares of a light that differ by more than this are two states.
constexpr float kSameShare = 0.02f;
/// Random numbers of directions to suns; those of places come before.
constexpr std::uint64_t kSunStream = 4096;
/// Those of a search.
constexpr std::uint64_t kSearchStream = 8192;
/// Half a diagonal, texels.
constexpr double kSixteenthRadius = 0.25 * 0.7072;

/// What one sixteenth of a texel sees of one light.
struct Sixteenth {
  Rgbd sum;
  double weight = 0;
  float lowest = 1, highest = 0;  // shares
  std::uint32_t taken = 0;
  bool mixed() const { return highest - lowest > kSameShare; }
  float middle() const { return 0.5f * (lowest + highest); }
};

/// The light of one sixteenth where its points do not tell the mean.
class Lamp {
 public:
  Lamp(const PunctualLight& light, const BakeInput& input, const TexelPoints::Point& about,
       double allowed) {
    cut_for_lamp(light, input.scene, input.layout, about, allowed, cells_);
    back_ = about.back;
    triangle_ = about.triangle;
    for (const LampCell& c : cells_) up_to_.push_back(total_ += c.light.sum());
    for (const LampCell& c : cells_) mean_ += to_double(c.light);
  }
  const Rgbd& mean() const { return mean_; }
  bool is_dark() const { return cells_.empty(); }

  /// A point of the surface, as often as light arrives there.
  TexelPoints::Point point(Vec2f random) const {
    const float wanted = random.x * total_;
    const auto found = std::upper_bound(up_to_.begin(), up_to_.end() - 1, wanted);
    const LampCell& cell = cells_[static_cast<std::size_t>(found - up_to_.begin())];
    const float light = cell.light.sum();
    const float within = std::clamp(1 - (*found - wanted) / light, 0.0f, 1.0f);
    const Vec2f step{(within - 0.5f) * cell.edge, (random.y - 0.5f) * cell.edge};
    return {triangle_, cell.at + step, back_};
  }

 private:
  std::vector<LampCell> cells_;
  std::vector<float> up_to_;
  float total_ = 0;
  Rgbd mean_;
  std::uint32_t triangle_ = 0;
  bool back_ = false;
};

/// Radius of the sphere about a middle point that holds all points of a texel and their shares.
float radius_about(const Receiver& middle, std::span<const Receiver> points, float margin) {
  float farthest = 0;
  for (const Receiver& p : points) {
    farthest = std::max(farthest, length(p.frame.position - middle.frame.position));
  }
  return farthest + margin;
}

/// Points on many small triangles, as on leaves: no neighbour tells what one of them sees.
bool is_crumpled(const TexelPoints& points) {
  std::uint32_t changes = 0;
  for (std::uint32_t i = 1; i < points.count; ++i) {
    if (points.point[i].triangle != points.point[0].triangle) ++changes;
  }
  return 2 * changes > points.count;
}

}  // namespace

PunctualTexel::PunctualTexel(const BakeInput& input, const GatherSettings& settings)
    : input_(input),
      settings_(settings),
      allowed_(settings.direct_error * input.mean_irradiance),
      lights_(input.direct.sources().punctual()) {}

bool PunctualTexel::is_behind_one_triangle(const PunctualLight& light, const TexelPoints& points,
                                           Receivers& receivers, BakeCounts& counts) const {
  // A sun of the sky is seen from points in other directions too. Where the surface ends within the
  // texel, its outermost points are not known.
  const bool whole = points.count == points.point.size() &&
                     std::all_of(points.point.begin(), points.point.end(), [&](const auto& p) {
                       return p.triangle == points.point[0].triangle && p.parts == 0;
                     });
  if (light.is_of_sky() || !whole) return false;
  std::uint32_t blocker = rays::kNoTriangle;
  for (const Vec2f corner : {Vec2f{0, 0}, Vec2f{1, 0}, Vec2f{0, 1}, Vec2f{1, 1}}) {
    const auto outer = [&](const TexelPoints::Point& p) {
      return (corner.x - 0.5f) * p.at.x + (corner.y - 0.5f) * p.at.y;
    };
    const auto* point =
        std::max_element(points.point.begin(), points.point.begin() + points.count,
                         [&](const auto& a, const auto& b) { return outer(a) < outer(b); });
    const std::uint32_t hit = input_.direct.blocker(receivers(*point, corner), light, counts.rays);
    if (hit == rays::kNoTriangle || (blocker != rays::kNoTriangle && hit != blocker)) return false;
    blocker = hit;
  }
  return true;
}

bool PunctualTexel::search(std::uint32_t t, const PunctualLight& light, const Rgb& share,
                           const TexelPoints& points, Receivers& receivers,
                           BakeCounts& counts) const {
  if (share.is_black() && is_behind_one_triangle(light, points, receivers, counts)) return false;
  const auto rays = static_cast<std::uint32_t>(
      std::clamp(settings_.rays / kRaysOverSearch, static_cast<int>(points.count), kMostSearched));
  const OwenSobol2 on_sun(static_cast<std::uint32_t>(item_seed(input_.seed, t, 292)));
  for (std::uint32_t i = 0; i < rays; ++i) {
    const std::uint32_t which = i % points.count;
    // One sequence for each point: of a common one, each would get a strip.
    const OwenSobol2 within(
        static_cast<std::uint32_t>(item_seed(input_.seed, t, kSearchStream + which)));
    const Receiver at = receivers(points.point[which], within.point(i / points.count));
    if (!(input_.direct.punctual_visibility(at, light, on_sun.point(i), counts.rays) == share)) {
      return true;
    }
  }
  return false;
}

Rgb PunctualTexel::pilot(std::uint32_t t, double dim, PunctualPilot& pilot, std::span<Rgb> by_group,
                         BakeCounts& counts) const {
  Rgbd sum;
  std::fill(by_group.begin(), by_group.end(), Rgb{});
  if (lights_.empty()) return {};
  const atlas::Texel& texel = input_.texels.texels[t];
  const TexelPoints points = texel_points(input_.texels, texel);
  const std::uint32_t used =
      is_crumpled(points)
          ? points.count
          : std::min(points.count,
                     static_cast<std::uint32_t>(std::clamp(settings_.pilot_rays, 1, 16)));
  const float lift = input_.direct.lift();
  const Receiver centre =
      receiver_at(input_.scene, input_.layout, central_point(input_.texels, texel), lift);
  Receivers receivers(input_.scene, input_.layout, lift);
  std::array<Receiver, 16> at;
  for (std::uint32_t i = 0; i < used; ++i) at[i] = receivers(points.point[i], {0.5f, 0.5f});
  const float radius =
      radius_about(centre, std::span(at).first(used),
                   static_cast<float>(kSixteenthRadius / input_.layout.texels_per_metre));
  std::uint32_t hash = 1;
  const OwenSobol2 on_sun(static_cast<std::uint32_t>(item_seed(input_.seed, t, 291)));
  for (const PunctualLight& light : lights_) {
    if (!input_.bakes_direct(light)) continue;
    Rgbd open;
    float least = std::numeric_limits<float>::infinity(), most = 0;
    for (std::uint32_t i = 0; i < used; ++i) {
      const Rgb value = light.irradiance(at[i].frame.position, at[i].frame.normal);
      least = std::min(least, value.max());
      most = std::max(most, value.max());
      open += to_double(value);
    }
    const bool close = varies_within(light, centre.frame.position, radius);
    if (open.is_black() && !close) {
      hash = hash * 0x9e3779b1u + 1;
      continue;
    }
    // The edge of a cone or of a range, a lamp close by, a sheet's edge, a shadow's edge.
    const Rgb share = input_.direct.punctual_visibility(centre, light, counts.rays);
    const bool uneven = static_cast<double>(most - least) > kMostUneven * dim * allowed_;
    bool mixed = close || least == 0 || (!share.is_black() && (uneven || !(share == Rgb{1, 1, 1})));
    for (std::uint32_t i = 0; pilot.thorough && i < used && !mixed; ++i) {
      mixed =
          !(input_.direct.punctual_visibility(at[i], light, on_sun.point(i), counts.rays) == share);
    }
    if (pilot.thorough && !mixed && open.sum() > 3 * kStrong * used * input_.mean_irradiance) {
      mixed = search(t, light, share, points, receivers, counts);
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
                              double may_be_off, BakeCounts& counts) const {
  const PunctualLight& light = lights_[l];
  Receivers receivers(input_.scene, input_.layout, input_.direct.lift());
  std::array<Sixteenth, 16> part;
  double open_sum = 0;
  std::array<std::optional<Lamp>, 16> lamp;
  std::array<bool, 16> edge{};
  for (std::uint32_t i = 0; i < points.count; ++i) {
    const Vec3f middle = receivers(points.point[i], {0.5f, 0.5f}).frame.position;
    const double radius = kSixteenthRadius / input_.layout.texels_per_metre;
    if (!varies_within(light, middle, static_cast<float>(radius))) continue;
    edge[i] = points.point[i].parts > 0;
    if (edge[i]) continue;
    lamp[i].emplace(light, input_, points.point[i], may_be_off);
    open_sum = std::max(open_sum, lamp[i]->mean().max());
  }
  const auto count = [&](std::uint32_t i, const Rgb& open, const Rgb& share, double weight) {
    const float seen = share.sum() / 3;
    part[i].lowest = std::min(part[i].lowest, seen);
    part[i].highest = std::max(part[i].highest, seen);
    part[i].sum += to_double(open * share) * weight;
    part[i].weight += weight;
    ++part[i].taken;
  };
  // Of a direction to a sun, against its middle: the higher edge brings more than the lower one.
  const auto weight_of = [&](const Receiver& at, Vec2f on_sun) {
    if (!light.is_of_sky()) return 1.0;
    const Vec3f towards = input_.direct.sources().sun(light).direction(on_sun);
    return static_cast<double>(std::max(0.0f, dot(at.frame.normal, towards)) /
                               -dot(at.frame.normal, light.direction));
  };
  const auto take = [&](std::uint32_t i, std::uint32_t begin, std::uint32_t end) {
    const OwenSobol2 shift(static_cast<std::uint32_t>(item_seed(input_.seed, t, 300 + 16 * l + i)));
    const OwenSobol2 on_sun(
        static_cast<std::uint32_t>(item_seed(input_.seed, t, kSunStream + 16 * l + i)));
    if (lamp[i]) {
      if (lamp[i]->is_dark()) return;
      for (std::uint32_t round = begin; round < end; ++round) {
        const Receiver at = receivers(lamp[i]->point(shift.point(round)), {0.5f, 0.5f});
        count(i, {1, 1, 1}, input_.direct.punctual_visibility(at, light, counts.rays), 1);
      }
      return;
    }
    for (std::uint32_t round = begin; round < end; ++round) {
      const Receiver at = receivers(points.point[i], shift.point(round));
      const Rgb open = light.irradiance(at.frame.position, at.frame.normal);
      const Rgb share = open.is_black() ? Rgb{}
                                        : input_.direct.punctual_visibility(
                                              at, light, on_sun.point(round), counts.rays);
      count(i, open, share, open.is_black() ? 1 : weight_of(at, on_sun.point(round)));
      open_sum = std::max(open_sum, static_cast<double>(open.max()));
    }
  };
  for (std::uint32_t i = 0; i < points.count; ++i) take(i, 0, kFirstRounds);
  // A strip that covers less of a sixteenth than one ray stands for may pass unseen.
  const double allowed = kUnseenShare * may_be_off;
  const auto first_rounds =
      static_cast<std::uint32_t>(std::clamp(allowed > 0 ? open_sum / (points.count * allowed) : 0,
                                            double{kFirstRounds}, kMostFirstRounds));
  for (std::uint32_t i = 0; i < points.count; ++i) take(i, kFirstRounds, first_rounds);
  for (std::uint32_t i = 0; i < points.count; ++i) {
    if (part[i].taken == 0) continue;
    edge[i] = edge[i] || part[i].mixed();
    for (std::uint32_t j = 0; j < points.count && !edge[i]; ++j) {
      edge[i] = adjacent(points.point[i], points.point[j]) && part[j].taken > 0 &&
                (part[j].mixed() || std::fabs(part[i].middle() - part[j].middle()) > kSameShare);
    }
  }
  // N samples go to each part that the edge touches: five of sixteen in an open place, all of few
  // or crumpled ones.
  const auto edges = static_cast<double>(std::count(edge.begin(), edge.end(), true));
  const auto rounds = static_cast<std::uint32_t>(samples_for_edge(
      open_sum, may_be_off, kEdgeError * std::sqrt(edges) / points.count, kMostEdgeRounds));
  Rgbd total;
  for (std::uint32_t i = 0; i < points.count; ++i) {
    if (edge[i] && rounds > first_rounds) take(i, first_rounds, rounds);
    if (!(part[i].weight > 0)) continue;
    const Rgbd mean = part[i].sum / part[i].weight;
    total += lamp[i] ? lamp[i]->mean() * mean : mean;
  }
  return total / static_cast<double>(points.count);
}

Rgb PunctualTexel::refined(std::uint32_t t, double dim, std::span<Rgb> by_group,
                           BakeCounts& counts) const {
  std::fill(by_group.begin(), by_group.end(), Rgb{});
  const TexelPoints points = texel_points(input_.texels, input_.texels.texels[t]);
  Rgbd total;
  for (std::size_t l = 0; l < lights_.size(); ++l) {
    if (!input_.bakes_direct(lights_[l])) continue;
    const Rgbd arrives = one_light(t, l, points, dim * allowed_, counts);
    total += arrives;
    if (!by_group.empty()) by_group[lights_[l].group] += to_float(arrives);
  }
  return to_float(total);
}

}  // namespace lightbatch::lightmap
