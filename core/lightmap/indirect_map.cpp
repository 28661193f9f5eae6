// Light from the hemisphere, shared between neighbours by a quadtree on each chart: texels are
// gathered at the corners and the middle of blocks; a block whose middle is well predicted by its
// corners is filled from them and it, others are split, down to single texels. Blocks are also
// split while their edge is long against the harmonic mean distance of what the corners see (Ward
// et al. 1988), so that contact shadows between the corners are not missed.
//
// Levels are worked one after another, all blocks of a level in parallel: no texel is gathered
// twice and nothing depends on the number of threads.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <span>
#include <utility>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/lightmap/bake.h"
#include "core/lightmap/block_curve.h"
#include "core/lightmap/blocks.h"
#include "core/lightmap/covered.h"
#include "core/lightmap/dim.h"
#include "core/lightmap/gather.h"
#include "core/lightmap/guide.h"
#include "core/lightmap/near_links.h"
#include "core/lightmap/neighbours.h"
#include "core/lightmap/ray_shares.h"
#include "core/lightmap/smooth.h"
#include "core/scene/scene.h"

namespace lightbatch::lightmap {
namespace {

constexpr int kFewestRays = 16;
/// Rays from which on guides learn before anything is computed, and the share that they learn by.
constexpr int kFewestGuided = 32;
constexpr double kShareOfLearning = 0.25;
/// Of the rays, for texels that a pilot's are linked to.
constexpr double kShareOfLinked = 0.25;
/// Texel edges from which on virtual lights serve: light varies little over the texel.
constexpr double kNearestVirtual = 2;
/// Standard errors that a block's middle may be off by for noise.
constexpr float kDeviations = 1.5f;
/// What noise does not excuse: more than so many tolerances and this share of a block's light.
constexpr double kLargeStep = 8;
constexpr float kMostExcused = 0.5f;
/// Corners whose normals differ more than this (cosine) do not share.
constexpr float kSameSurface = 0.97f;

class IndirectMap {
 public:
  IndirectMap(const BakeInput& input, const GatherSettings& settings, const DimShares& dim,
              radiosity::GroupedLight& by_group, BakeCounts& counts, const Progress& progress)
      : input_(input),
        settings_(settings),
        total_by_group_(by_group),
        by_group_(by_group.is_empty() ? 0 : input.texels.texels.size(), by_group.groups()),
        counts_(counts),
        progress_(progress),
        dim_(dim),
        near_(input, settings.linked),
        lights_(input.scene, input.elements, input.direct, input.solution,
                {static_cast<std::size_t>(settings.virtual_lights),
                 kNearestVirtual / input.layout.texels_per_metre, input.seed}),
        aids_{near_, lights_},
        gather_(input, settings, &aids_),
        guides_(input.layout),
        links_(input.texels.texels.size()),
        texel_(input.texels.texels.size()),
        state_(input.texels.texels.size(), kUnknown) {}

  std::vector<Rgb> run() {
    share_ = ray_shares(input_, dim_, near_.first());
    std::vector<Block> blocks = first_blocks();
    if (!blocks.empty()) {
      // They do not share with open ones, whatever the corners of a block say.
      const std::vector<std::uint8_t> covered = find_covered(input_);
      for (std::size_t t = 0; t < covered.size(); ++t) texel_[t].covered = covered[t] != 0;
    }
    // Tiny charts and single texels have no corners to share with.
    while (!blocks.empty() && !progress_.cancelled()) {
      std::vector<std::uint32_t> wanted;
      for (const Block& b : blocks) request(b, wanted);
      if (computed_so_far_ == 0) learn(wanted);
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
    if (input_.selected != nullptr && !progress_.cancelled()) compute_linked();
    if (progress_.cancelled()) return {};
    solve_links();
    smooth_gathered(input_.layout, input_.texels, settings_.reach, texel_, by_group_);
    fill_all();
    std::vector<Rgb> irradiance(texel_.size());
    for (std::size_t t = 0; t < texel_.size(); ++t) irradiance[t] = texel_[t].irradiance;
    total_by_group_ += by_group_;
    return irradiance;
  }

  /// Wall time of gathering.
  double seconds() const { return seconds_; }

 private:
  enum State : std::uint8_t { kUnknown, kRequested, kComputed, kShared };

  int rays_of(std::uint32_t t, double share) const {
    const double wanted = share * static_cast<double>(share_[t]) * settings_.rays;
    return std::max(kFewestRays, static_cast<int>(wanted));
  }

  std::uint32_t texel_at(const Block& b, int x, int y) const {
    return lightmap::texel_at(input_.texels, input_.layout, b.chart, x, y);
  }

  std::vector<Block> first_blocks() const {
    std::vector<Block> blocks;
    for_each_block(input_.layout, settings_.block, [&](const Block& b) {
      if (is_selected(b)) blocks.push_back(b);
    });
    return blocks;
  }

  /// Blocks are selected whole; their first row and column belong to the blocks before them.
  bool is_selected(const Block& b) const {
    if (input_.selected == nullptr) return true;
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

  /// What one tile's texels brought.
  struct Gathered {
    BakeCounts counts;
    std::vector<NearLink> links;
    GuideGrid learned;
  };

  /// Visits texels tile by tile, in parallel, with rays where the tile's guide sends them.
  /// visit(index of the texel, scratch, gathered).
  template <typename Visit>
  std::vector<Gathered> for_tiles(std::span<const Guides::Group> groups, Visit visit) {
    const auto began = std::chrono::steady_clock::now();
    std::vector<Gathered> gathered(groups.size());
    parallel_for(groups.size(), 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t g = first; g < last && !progress_.cancelled(); ++g) {
        Gather::Scratch scratch;
        if (groups[g].tile != Guides::kNoTile) scratch.guide = guides_.guide(groups[g].tile);
        for (std::size_t i = groups[g].begin; i < groups[g].end; ++i) {
          visit(i, scratch, gathered[g]);
        }
        gathered[g].learned = scratch.learned;
      }
    });
    for (std::size_t g = 0; g < groups.size(); ++g) {
      counts_ += gathered[g].counts;
      if (groups[g].tile != Guides::kNoTile) guides_.add(groups[g].tile, gathered[g].learned);
    }
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    return gathered;
  }

  /// Rays since `before` of a texel that only others need.
  void count_border(std::uint32_t t, std::uint64_t before, BakeCounts& counts) const {
    if (input_.selected == nullptr || (*input_.selected)[t] != 0) return;
    counts.border_rays += counts.rays.cast() - before;
  }

  /// share: of their rays.
  void compute(std::vector<std::uint32_t>& wanted, double share = 1) {
    const std::vector<Guides::Group> groups = guides_.sort(input_.texels, wanted);
    std::vector<std::uint32_t> links(wanted.size());
    auto gathered = for_tiles(groups, [&](std::size_t i, auto& scratch, Gathered& all) {
      const std::uint64_t before = all.counts.rays.cast();
      compute_one(wanted[i], share, scratch, all.counts);
      count_border(wanted[i], before, all.counts);
      links[i] = static_cast<std::uint32_t>(scratch.links.size());
      all.links.insert(all.links.end(), scratch.links.begin(), scratch.links.end());
    });
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const std::size_t begin = groups[g].begin, count = groups[g].end - begin;
      links_.add(std::span(wanted).subspan(begin, count), std::span(links).subspan(begin, count),
                 std::move(gathered[g].links));
    }
    counts_.computed_texels += wanted.size();
    computed_so_far_ += wanted.size();
    progress_.report("gather", static_cast<double>(computed_so_far_) /
                                   static_cast<double>(std::max<std::size_t>(1, state_.size())));
  }

  /// A few rays of the first texels that tell their guides and nothing else: the corners of blocks
  /// decide on what lies between.
  void learn(std::vector<std::uint32_t> texels) {
    if (settings_.rays < kFewestGuided) return;
    const std::vector<Guides::Group> groups = guides_.sort(input_.texels, texels);
    for_tiles(groups, [&](std::size_t i, auto& scratch, Gathered& all) {
      const std::uint64_t before = all.counts.rays.cast();
      const std::uint32_t t = texels[i];
      gather_(texel_points(input_.texels, input_.texels.texels[t]), rays_of(t, kShareOfLearning),
              static_cast<std::uint32_t>(item_seed(input_.seed, t, 22)), {}, scratch, all.counts);
      count_border(t, before, all.counts);
    });
  }

  void compute_one(std::uint32_t t, double share, Gather::Scratch& scratch, BakeCounts& counts) {
    const TexelPoints points = texel_points(input_.texels, input_.texels.texels[t]);
    const Gather::Value v = gather_(points, rays_of(t, share),
                                    static_cast<std::uint32_t>(item_seed(input_.seed, t, 21)),
                                    by_group_.of(t), scratch, counts);
    texel_[t].irradiance = v.irradiance;
    texel_[t].variance = v.variance;
    texel_[t].normal = receiver_at(input_.scene, input_.layout, points.point[0], 0.0f).frame.normal;
    texel_[t].gathered = true;
    texel_[t].distance = v.distance;
    state_[t] = kComputed;
  }

  /// Texels that selected ones are linked to, by fewer rays: many share in a link's light.
  void compute_linked() {
    std::vector<std::uint32_t> linked;
    links_.for_each([&](const NearLink& link) { want(link.texel, linked); });
    std::sort(linked.begin(), linked.end());
    compute(linked, kShareOfLinked);
  }

  void solve_links() {
    std::vector<std::uint8_t> known(state_.size());
    for (std::size_t t = 0; t < known.size(); ++t) {
      known[t] = state_[t] == kComputed || state_[t] == kShared ? 1 : 0;
    }
    links_.solve(near_.first(), known, texel_, by_group_, [&] { fill_all(); });
  }

  void fill_all() {
    for (const Block& b : filled_) fill(b);
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
        next.push_back({b.chart, x[0], y[0], x[1], y[1]});
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
    const std::uint32_t middle = texel_at(b, xm, ym);
    const MiddleOff off = middle_off(texel_, corner, middle, corner_shares(b, xm, ym));
    const float worst =
        std::max({std::fabs(off.lux.r), std::fabs(off.lux.g), std::fabs(off.lux.b)});
    const double tolerance = settings_.tolerance * dim_.at(middle) * input_.mean_irradiance;
    if (static_cast<double>(worst) <= tolerance) return true;
    // Noise alone makes as much: finer texels would be as noisy. But not a step: where few rays
    // find the light, as at the mouth of a crack, variance explains everything.
    const Rgb guess = texel_[middle].irradiance - off.lux;
    const bool step = static_cast<double>(worst) > kLargeStep * tolerance &&
                      worst > kMostExcused * std::max(guess.max(), texel_[middle].irradiance.max());
    if (step) return false;
    return worst * worst <= kDeviations * kDeviations * off.variance;
  }

  void fill(const Block& b) {
    std::array<std::uint32_t, 4> corner{};
    float nearest = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < 4; ++i) {
      corner[i] = texel_at(b, corners(b)[i][0], corners(b)[i][1]);
      nearest = std::min(nearest, texel_[corner[i]].distance);
    }
    const int xm = (b.x0 + b.x1) / 2, ym = (b.y0 + b.y1) / 2;
    const std::uint32_t middle = texel_at(b, xm, ym);
    const std::array<float, 4> at_middle = corner_shares(b, xm, ym);
    // A middle that is shared itself, in a larger block, tells nothing.
    const MiddleOff off =
        state_[middle] == kComputed ? middle_off(texel_, corner, middle, at_middle) : MiddleOff{};
    BlockCurve curve(off, at_middle);
    curve.keep_positive(corner, middle, [&](std::uint32_t t) { return texel_[t].irradiance; });
    for (std::size_t g = 0; g < by_group_.groups(); ++g) {
      curve.keep_positive(corner, middle, [&](std::uint32_t t) { return by_group_.of(t)[g]; });
    }
    for (int y = b.y0; y <= b.y1; ++y) {
      for (int x = b.x0; x <= b.x1; ++x) {
        const std::uint32_t t = texel_at(b, x, y);
        if (state_[t] != kUnknown && state_[t] != kShared) continue;
        // A corner may be shared itself, in a larger block.
        if (std::find(corner.begin(), corner.end(), t) != corner.end()) continue;
        std::array<float, 4> share = corner_shares(b, x, y);
        const float of_middle = curve.of_middle(share);
        texel_[t].irradiance = texel_[middle].irradiance * of_middle;
        texel_[t].normal = texel_[corner[0]].normal;
        texel_[t].distance = nearest;
        for (std::size_t g = 0; g < by_group_.groups(); ++g) {
          by_group_.of(t)[g] = by_group_.of(middle)[g] * of_middle;
        }
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
  const DimShares& dim_;
  NearTexels near_;
  radiosity::VirtualLights lights_;
  Gather::Aids aids_;
  Gather gather_;
  Guides guides_;
  NearLinks links_;
  std::vector<GatheredTexel> texel_;
  std::vector<Block> filled_;  // shared, coarse ones first
  std::vector<std::uint8_t> state_;
  std::vector<float> share_;  // of each texel in the rays, mean 1
  std::size_t computed_so_far_ = 0;
  double seconds_ = 0;
};

}  // namespace

std::vector<Rgb> bake_indirect(const BakeInput& input, const GatherSettings& settings,
                               const DimShares& dim, radiosity::GroupedLight& by_group,
                               BakeCounts& counts, const Progress& progress, double* seconds) {
  if (!input.indirect) return std::vector<Rgb>(input.texels.texels.size());
  IndirectMap map(input, settings, dim, by_group, counts, progress);
  std::vector<Rgb> irradiance = map.run();
  if (seconds != nullptr) *seconds = map.seconds();
  return irradiance;
}

}  // namespace lightbatch::lightmap
