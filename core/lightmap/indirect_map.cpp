// Light from the hemisphere, shared between neighbours by a quadtree on each chart: texels are
// gathered at the corners and the middle of blocks; a block whose middle is well predicted by its
// corners is filled bilinearly, others are split, down to single texels. Blocks are also split
// while their edge is long against the harmonic mean distance of what the corners see (Ward et al.
// 1988), so that contact shadows between the corners are not missed.
//
// Levels are worked one after another, all blocks of a level in parallel: no texel is gathered
// twice and nothing depends on the number of threads.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/lightmap/bake.h"
#include "core/lightmap/gather.h"
#include "core/lightmap/smooth.h"
#include "core/scene/scene.h"

namespace lightbatch::lightmap {
namespace {

constexpr std::size_t kGrain = 64;
constexpr double kShareOfLight = 2 / 2.4;
/// Limits of a texel's rays against the mean: the first stage may be wrong about a texel.
constexpr float kFewestShare = 0.25f;
constexpr float kMostShare = 8.0f;
constexpr int kFewestRays = 16;
/// Standard errors that a block's middle may be off by for noise.
constexpr float kDeviations = 1.5f;
/// What noise does not excuse: more than so many tolerances and this share of a block's light.
constexpr double kLargeStep = 8;
constexpr float kMostExcused = 0.5f;
/// Corners whose normals differ more than this (cosine) do not share.
constexpr float kSameSurface = 0.97f;

/// Texel rectangle with computed corners, both ends included, in page coordinates.
struct Block {
  std::uint32_t chart = 0;
  std::uint16_t page = 0;
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// The blocks of a layout, chart by chart. Tiny and thin charts have none.
template <typename Visit>
void for_each_block(const atlas::Layout& layout, int step, Visit visit) {
  if (step <= 1) return;
  for (std::uint32_t c = 0; c < layout.charts.size(); ++c) {
    const atlas::Chart& chart = layout.charts[c];
    if (chart.tiny || chart.width < 3 || chart.height < 3) continue;
    const int x_last = chart.x + chart.width - 1;
    const int y_last = chart.y + chart.height - 1;
    for (int y = chart.y; y < y_last; y += step) {
      for (int x = chart.x; x < x_last; x += step) {
        visit(Block{c, static_cast<std::uint16_t>(chart.page), x, y, std::min(x + step, x_last),
                    std::min(y + step, y_last)});
      }
    }
  }
}

class IndirectMap {
 public:
  IndirectMap(const BakeInput& input, const GatherSettings& settings,
              radiosity::GroupedLight& by_group, BakeCounts& counts, const Progress& progress)
      : input_(input),
        settings_(settings),
        total_by_group_(by_group),
        by_group_(by_group.is_empty() ? 0 : input.texels.texels.size(), by_group.groups()),
        counts_(counts),
        progress_(progress),
        gather_(input, settings),
        texel_(input.texels.texels.size()),
        state_(input.texels.texels.size(), kUnknown) {}

  std::vector<Rgb> run() {
    share_rays();
    std::vector<Block> blocks = first_blocks();
    if (!blocks.empty()) find_covered();
    // Tiny charts and single texels have no corners to share with.
    while (!blocks.empty() && !progress_.cancelled()) {
      std::vector<std::uint32_t> wanted;
      for (const Block& b : blocks) request(b, wanted);
      compute(wanted);
      std::vector<Block> next;
      for (const Block& b : blocks) settle(b, next);
      blocks.swap(next);
    }
    std::vector<std::uint32_t> rest;
    for (std::uint32_t t = 0; t < state_.size(); ++t) {
      if (input_.selected != nullptr && (*input_.selected)[t] == 0) continue;
      want(t, rest);
    }
    if (!progress_.cancelled()) compute(rest);
    smooth_gathered(input_.layout, input_.texels, settings_.reach, texel_, by_group_);
    for (const Block& b : filled_) fill(b);
    std::vector<Rgb> irradiance(texel_.size());
    for (std::size_t t = 0; t < texel_.size(); ++t) irradiance[t] = texel_[t].irradiance;
    total_by_group_ += by_group_;
    return irradiance;
  }

 private:
  enum State : std::uint8_t { kUnknown, kRequested, kComputed, kShared };

  /// Rays in proportion to what a texel brings into the error of the map: noise grows with the
  /// indirect light that the first stage found there, and falls with the rays to the power 0.7; its
  /// square counts by the texel's surface. The least sum of squares for a number of rays has rays
  /// ~ (light^2 surface)^(1 / 2.4).
  void share_rays() {
    share_.assign(state_.size(), 1.0f);
    const auto& indirect = input_.solution.indirect;
    if (indirect.empty()) return;
    parallel_for(state_.size(), 1024, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        const TexelPoints::Point p = central_point(input_.texels, input_.texels.texels[t]);
        const atlas::SurfacePoint at = atlas::point_at(input_.layout, p.triangle, p.at);
        const radiosity::ElementId e = input_.elements.at(at.triangle, at.u, at.v, p.back);
        const double whole = 1 / (input_.layout.texels_per_metre * input_.layout.texels_per_metre);
        const double part =
            std::min(1.0, input_.texels.surface_of(input_.texels.texels[t]) / whole);
        share_[t] = e == radiosity::kNoElement
                        ? 0.0f
                        : indirect[e].sum() * static_cast<float>(std::sqrt(part));
      }
    });
    double mean = 0;
    for (const float v : share_)
      mean += static_cast<double>(v) / static_cast<double>(share_.size());
    if (!(mean > 0)) {
      share_.assign(state_.size(), 1.0f);
      return;
    }
    double sum = 0;
    for (float& v : share_) {
      v = std::clamp(static_cast<float>(std::pow(static_cast<double>(v) / mean, kShareOfLight)),
                     kFewestShare, kMostShare);
      sum += static_cast<double>(v);
    }
    const auto scale = static_cast<float>(static_cast<double>(share_.size()) / sum);
    for (float& v : share_) v *= scale;
  }

  int rays_of(std::uint32_t t) const {
    return std::max(kFewestRays, static_cast<int>(share_[t] * static_cast<float>(settings_.rays)));
  }

  /// Texels with something closer above them than their own edge: under furniture, behind frames.
  /// They do not share with open ones, whatever the corners of a block say.
  void find_covered() {
    const auto edge = static_cast<float>(1.0 / input_.layout.texels_per_metre);
    parallel_for(state_.size(), 1024, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        if (input_.selected != nullptr && (*input_.selected)[t] == 0) continue;
        const auto at = receiver_at(input_.scene, input_.layout,
                                    central_point(input_.texels, input_.texels.texels[t]),
                                    input_.direct.lift());
        const rays::Ray up{at.frame.origin, at.frame.normal, 0.0f, edge};
        texel_[t].covered = input_.caster.occluded(up, at.triangle);
      }
    });
  }

  std::uint32_t texel_at(const Block& b, int x, int y) const {
    const int width = input_.layout.pages[b.page].width;
    const std::uint32_t t = input_.texels.index[b.page][static_cast<std::size_t>(y * width + x)];
    return t != scene::kNone && input_.texels.texels[t].chart == b.chart ? t : scene::kNone;
  }

  std::vector<Block> first_blocks() const {
    std::vector<Block> blocks;
    for_each_block(input_.layout, settings_.block, [&](const Block& b) {
      if (input_.selected == nullptr || any_selected(b)) blocks.push_back(b);
    });
    return blocks;
  }

  /// Blocks are selected whole; their first row and column belong to the blocks before them.
  bool any_selected(const Block& b) const {
    for (int y = b.y0 + 1; y <= b.y1; ++y) {
      for (int x = b.x0 + 1; x <= b.x1; ++x) {
        const std::uint32_t t = texel_at(b, x, y);
        if (t != scene::kNone) return (*input_.selected)[t] != 0;
      }
    }
    return false;
  }

  void want(std::uint32_t t, std::vector<std::uint32_t>& wanted) {
    if (t == scene::kNone || state_[t] != kUnknown) return;
    state_[t] = kRequested;
    wanted.push_back(t);
  }

  static std::array<std::array<int, 2>, 4> corners(const Block& b) {
    return {{{b.x0, b.y0}, {b.x1, b.y0}, {b.x0, b.y1}, {b.x1, b.y1}}};
  }

  void request(const Block& b, std::vector<std::uint32_t>& wanted) {
    for (const auto& c : corners(b)) want(texel_at(b, c[0], c[1]), wanted);
    want(texel_at(b, (b.x0 + b.x1) / 2, (b.y0 + b.y1) / 2), wanted);
  }

  void compute(const std::vector<std::uint32_t>& wanted) {
    std::vector<BakeCounts> block((wanted.size() + kGrain - 1) / kGrain);
    parallel_for(wanted.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      if (progress_.cancelled()) return;
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t t = wanted[i];
        const TexelPoints points = texel_points(input_.texels, input_.texels.texels[t]);
        const Gather::Value v =
            gather_(points, rays_of(t), static_cast<std::uint32_t>(item_seed(input_.seed, t, 21)),
                    by_group_.of(t), block[begin / kGrain]);
        texel_[t].irradiance = v.irradiance;
        texel_[t].variance = v.variance;
        texel_[t].normal =
            receiver_at(input_.scene, input_.layout, points.point[0], 0.0f).frame.normal;
        texel_[t].gathered = true;
        texel_[t].distance = v.distance;
        state_[t] = kComputed;
      }
    });
    for (const BakeCounts& c : block) counts_ += c;
    counts_.computed_texels += wanted.size();
    for (const std::uint32_t t : wanted) {
      if (input_.selected != nullptr && (*input_.selected)[t] == 0) ++counts_.border_texels;
    }
    computed_so_far_ += wanted.size();
    progress_.report("gather", static_cast<double>(computed_so_far_) /
                                   static_cast<double>(std::max<std::size_t>(1, state_.size())));
  }

  /// Fills the block from its corners, or cuts it in (up to) four.
  void settle(const Block& b, std::vector<Block>& next) {
    if (b.x1 - b.x0 <= 1 && b.y1 - b.y0 <= 1) return;
    if (predicted(b)) {
      filled_.push_back(b);
      fill(b);
      return;
    }
    const int xm = (b.x0 + b.x1) / 2;
    const int ym = (b.y0 + b.y1) / 2;
    const std::array<std::array<int, 2>, 2> xs{{{b.x0, xm}, {xm, b.x1}}};
    const std::array<std::array<int, 2>, 2> ys{{{b.y0, ym}, {ym, b.y1}}};
    for (const auto& y : ys) {
      if (y[0] == y[1] && b.y0 != b.y1) continue;
      for (const auto& x : xs) {
        if (x[0] == x[1] && b.x0 != b.x1) continue;
        next.push_back({b.chart, b.page, x[0], y[0], x[1], y[1]});
      }
    }
  }

  bool predicted(const Block& b) const {
    std::array<std::uint32_t, 4> corner{};
    float nearest = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < 4; ++i) {
      const auto c = corners(b)[i];
      corner[i] = texel_at(b, c[0], c[1]);
      if (corner[i] == scene::kNone) return false;
      nearest = std::min(nearest, texel_[corner[i]].distance);
      if (dot(texel_[corner[i]].normal, texel_[corner[0]].normal) < kSameSurface) return false;
    }
    for (int y = b.y0; y <= b.y1; ++y) {
      for (int x = b.x0; x <= b.x1; ++x) {
        const std::uint32_t t = texel_at(b, x, y);
        if (t == scene::kNone || texel_[t].covered != texel_[corner[0]].covered) return false;
      }
    }
    const double edge = std::max(b.x1 - b.x0, b.y1 - b.y0) / input_.layout.texels_per_metre;
    // Under what is nearer than a texel nothing finer is to be seen.
    if (!texel_[corner[0]].covered && edge > settings_.reach * static_cast<double>(nearest)) {
      return false;
    }
    const int xm = (b.x0 + b.x1) / 2;
    const int ym = (b.y0 + b.y1) / 2;
    const std::array<float, 4> share = shares(b, xm, ym);
    Rgb guess{};
    for (std::size_t i = 0; i < 4; ++i) guess += texel_[corner[i]].irradiance * share[i];
    const std::uint32_t middle = texel_at(b, xm, ym);
    const Rgb off = texel_[middle].irradiance - guess;
    const float worst = std::max({std::fabs(off.r), std::fabs(off.g), std::fabs(off.b)});
    if (static_cast<double>(worst) <= settings_.tolerance * input_.mean_irradiance) return true;
    // Noise alone makes as much: finer texels would be as noisy. But not a step: where few rays
    // find the light, as at the mouth of a crack, variance explains everything.
    const bool step =
        static_cast<double>(worst) > kLargeStep * settings_.tolerance * input_.mean_irradiance &&
        worst > kMostExcused * std::max(guess.max(), texel_[middle].irradiance.max());
    if (step) return false;
    float variance = texel_[middle].variance;
    for (const std::uint32_t c : corner) variance += texel_[c].variance;
    variance *= (1 + 0.25f) / 5;
    return worst * worst <= kDeviations * kDeviations * variance;
  }

  /// Of the corners, in a bilinear mean at a texel.
  static std::array<float, 4> shares(const Block& b, int x, int y) {
    const float s =
        b.x1 > b.x0 ? static_cast<float>(x - b.x0) / static_cast<float>(b.x1 - b.x0) : 0;
    const float t =
        b.y1 > b.y0 ? static_cast<float>(y - b.y0) / static_cast<float>(b.y1 - b.y0) : 0;
    return {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t};
  }

  void fill(const Block& b) {
    std::array<std::uint32_t, 4> corner{};
    for (std::size_t i = 0; i < 4; ++i) corner[i] = texel_at(b, corners(b)[i][0], corners(b)[i][1]);
    for (int y = b.y0; y <= b.y1; ++y) {
      for (int x = b.x0; x <= b.x1; ++x) {
        const std::uint32_t t = texel_at(b, x, y);
        if (state_[t] != kUnknown && state_[t] != kShared) continue;
        const std::array<float, 4> share = shares(b, x, y);
        texel_[t].irradiance = {};
        for (Rgb& part : by_group_.of(t)) part = {};
        for (std::size_t i = 0; i < 4; ++i) {
          texel_[t].irradiance += texel_[corner[i]].irradiance * share[i];
          for (std::size_t g = 0; g < by_group_.groups(); ++g) {
            by_group_.of(t)[g] += by_group_.of(corner[i])[g] * share[i];
          }
        }
        state_[t] = kShared;
      }
    }
  }

  const BakeInput& input_;
  const GatherSettings& settings_;
  radiosity::GroupedLight& total_by_group_;
  radiosity::GroupedLight by_group_;  // the hemisphere's
  BakeCounts& counts_;
  const Progress& progress_;
  Gather gather_;
  std::vector<GatheredTexel> texel_;
  std::vector<Block> filled_;  // shared, coarse ones first
  std::vector<std::uint8_t> state_;
  std::vector<float> share_;  // of each texel in the rays, mean 1
  std::size_t computed_so_far_ = 0;
};

}  // namespace

std::vector<std::uint8_t> select_texels(const atlas::Layout& layout, const atlas::TexelMap& map,
                                        int block, std::uint32_t divisor) {
  enum : std::uint8_t { kFree, kPassedOver, kSelected };
  std::vector<std::uint8_t> mark(map.texels.size(), kFree);
  std::uint32_t block_number = 0;
  for_each_block(layout, block, [&](const Block& b) {
    // Every divisor-th block, one at random of each run.
    const std::uint32_t run = block_number / divisor;
    const std::uint8_t chosen =
        item_seed(0xb10c, run) % divisor == block_number % divisor ? kSelected : kPassedOver;
    ++block_number;
    const int width = layout.pages[b.page].width;
    for (int y = b.y0; y <= b.y1; ++y) {
      for (int x = b.x0; x <= b.x1; ++x) {
        const std::uint32_t t = map.index[b.page][static_cast<std::size_t>(y * width + x)];
        if (t != scene::kNone && map.texels[t].chart == b.chart && mark[t] == kFree) {
          mark[t] = chosen;
        }
      }
    }
  });
  for (std::uint32_t t = 0; t < mark.size(); ++t) {
    if (mark[t] == kFree) mark[t] = item_seed(0x7e6e1, t) % divisor == 0 ? kSelected : kPassedOver;
    mark[t] = mark[t] == kSelected ? 1 : 0;
  }
  return mark;
}

std::vector<Rgb> bake_indirect(const BakeInput& input, const GatherSettings& settings,
                               radiosity::GroupedLight& by_group, BakeCounts& counts,
                               const Progress& progress) {
  if (!input.indirect) return std::vector<Rgb>(input.texels.texels.size());
  return IndirectMap(input, settings, by_group, counts, progress).run();
}

Result<BakedTexels> bake_texels(const BakeInput& input, const GatherSettings& settings,
                                const Progress& progress) {
  BakedTexels baked;
  baked.counts.texels = input.texels.texels.size();
  progress.report("direct", 0);
  const auto began = std::chrono::steady_clock::now();
  baked.by_group =
      radiosity::GroupedLight(input.groups > 0 ? input.texels.texels.size() : 0, input.groups);
  baked.direct = bake_direct(input, settings, baked.by_group, baked.counts, progress);
  baked.direct_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  baked.direct_rays = baked.counts.rays.cast();
  if (progress.cancelled()) return cancelled();
  progress.report("gather", 0);
  baked.irradiance = bake_indirect(input, settings, baked.by_group, baked.counts, progress);
  if (progress.cancelled()) return cancelled();
  for (std::size_t t = 0; t < baked.direct.size(); ++t) baked.irradiance[t] += baked.direct[t];
  return baked;
}

}  // namespace lightbatch::lightmap
