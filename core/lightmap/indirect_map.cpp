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
#include "core/lightmap/blocks.h"
#include "core/lightmap/covered.h"
#include "core/lightmap/dim.h"
#include "core/lightmap/gather.h"
#include "core/lightmap/guide.h"
#include "core/lightmap/near_links.h"
#include "core/lightmap/neighbours.h"
#include "core/lightmap/ray_shares.h"
#include "core/lightmap/shared_blocks.h"
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
/// Of blocks that the light of linked texels tells to cut, at most: each is half as wide as before.
constexpr int kMostRounds = 4;
/// Texel edges from which on virtual lights serve: light varies little over the texel.
constexpr double kNearestVirtual = 2;
class IndirectMap {
 public:
  IndirectMap(const BakeInput& input, const GatherSettings& settings, const DimShares& dim,
              radiosity::GroupedLight& by_group, BakeCounts& counts, const Progress& progress)
      : input_(input),
        settings_(settings),
        total_by_group_(by_group),
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
        map_(input.texels.texels.size(), by_group.groups()),
        blocks_(input, settings, dim, map_),
        start_{std::vector<Rgb>(input.texels.texels.size()), map_.by_group} {}

  std::vector<Rgb> run() {
    share_ = ray_shares(input_, dim_, near_.first());
    std::vector<Block> blocks = first_blocks();
    if (!blocks.empty()) {
      // They do not share with open ones, whatever the corners of a block say.
      const std::vector<std::uint8_t> covered = find_covered(input_);
      for (std::size_t t = 0; t < covered.size(); ++t) map_.texel[t].covered = covered[t] != 0;
    }
    settle_all(std::move(blocks));
    // Tiny charts and single texels have no corners to share with.
    std::vector<std::uint32_t> rest;
    for (std::uint32_t t = 0; t < map_.state.size(); ++t) {
      if (input_.selected != nullptr && (*input_.selected)[t] == 0) continue;
      want(t, rest);
    }
    if (!progress_.cancelled()) compute(rest);
    if (input_.selected != nullptr && !progress_.cancelled()) compute_linked();
    if (progress_.cancelled()) return {};
    solve_links();
    for (int round = 0; round < kMostRounds; ++round) {
      if (!settle_again()) break;
      if (progress_.cancelled()) return {};
      solve_links();
    }
    smooth_gathered(input_.layout, input_.texels, settings_.reach, map_.texel, map_.by_group);
    fill_all();
    std::vector<Rgb> irradiance(map_.texel.size());
    for (std::size_t t = 0; t < map_.texel.size(); ++t) irradiance[t] = map_.texel[t].irradiance;
    total_by_group_ += map_.by_group;
    return irradiance;
  }

  /// Wall time of gathering.
  double seconds() const { return seconds_; }

 private:
  void settle_all(std::vector<Block> blocks) {
    while (!blocks.empty() && !progress_.cancelled()) {
      std::vector<std::uint32_t> wanted;
      for (const Block& b : blocks) {
        blocks_.for_each_asked(b, [&](std::uint32_t t) { want(t, wanted); });
      }
      if (computed_so_far_ == 0) learn(wanted);
      compute(wanted);
      std::vector<Block> next;
      for (const Block& b : blocks) settle(b, next);
      blocks.swap(next);
    }
  }

  /// Once the light of linked texels is known: cuts blocks that are not predicted any more. Whether
  /// there were any.
  bool settle_again() {
    std::vector<Block> kept, cleared, again;
    for (const Block& b : filled_) (blocks_.is_predicted(b) ? kept : cleared).push_back(b);
    if (cleared.empty()) return false;
    for (const Block& b : cleared) {
      blocks_.clear(b);
      SharedBlocks::cut(b, again);
    }
    filled_.swap(kept);
    fill_all();
    settle_all(std::move(again));
    if (input_.selected != nullptr && !progress_.cancelled()) compute_linked();
    return true;
  }

  int rays_of(std::uint32_t t, double share) const {
    const double wanted = share * static_cast<double>(share_[t]) * settings_.rays;
    return std::max(kFewestRays, static_cast<int>(wanted));
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
        const std::uint32_t t = texel_at(input_.texels, input_.layout, b.chart, x, y);
        if (t != scene::kNone) return (*input_.selected)[t] != 0;
      }
    }
    return false;
  }

  void want(std::uint32_t t, std::vector<std::uint32_t>& wanted) {
    if (t == scene::kNone || map_.state[t] != TexelState::kUnknown) return;
    map_.state[t] = TexelState::kRequested;
    wanted.push_back(t);
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
    start(wanted);
    counts_.computed_texels += wanted.size();
    computed_so_far_ += wanted.size();
    progress_.report("gather",
                     static_cast<double>(computed_so_far_) /
                         static_cast<double>(std::max<std::size_t>(1, map_.state.size())));
  }

  /// Keeps what the rays brought, and gives texels of later rounds the light of those they are
  /// linked to, as their neighbours have it.
  void start(const std::vector<std::uint32_t>& computed) {
    parallel_for(computed.size(), 1024, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t t = computed[i];
        const std::span<const Rgb> groups = map_.by_group.of(t);
        std::copy(groups.begin(), groups.end(), start_.by_group.of(t).begin());
        start_.irradiance[t] = map_.texel[t].irradiance;
      }
    });
    if (known_.empty()) return;
    std::vector<Rgb> linked(computed.size());
    parallel_for(computed.size(), 1024, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        linked[i] = links_.linked(computed[i], near_.first(), known_, start_, map_.texel);
      }
    });
    for (std::size_t i = 0; i < computed.size(); ++i) {
      map_.texel[computed[i]].irradiance = linked[i];
    }
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
                                    map_.by_group.of(t), scratch, counts);
    map_.texel[t].irradiance = v.irradiance;
    map_.texel[t].variance = v.variance;
    map_.texel[t].normal =
        receiver_at(input_.scene, input_.layout, points.point[0], 0.0f).frame.normal;
    map_.texel[t].gathered = true;
    map_.texel[t].distance = v.distance;
    map_.state[t] = TexelState::kComputed;
  }

  /// Texels that selected ones are linked to, by fewer rays: many share in a link's light.
  void compute_linked() {
    std::vector<std::uint32_t> linked;
    links_.for_each([&](const NearLink& link) { want(link.texel, linked); });
    std::sort(linked.begin(), linked.end());
    compute(linked, kShareOfLinked);
  }

  void solve_links() {
    known_.resize(map_.state.size());
    for (std::size_t t = 0; t < known_.size(); ++t) known_[t] = map_.is_known(t) ? 1 : 0;
    links_.solve(near_.first(), known_, start_, map_.texel, map_.by_group, [&] { fill_all(); });
  }

  void fill_all() {
    for (const Block& b : filled_) blocks_.fill(b);
  }

  /// Fills the block from its corners, or cuts it in (up to) four.
  void settle(const Block& b, std::vector<Block>& next) {
    if (b.x1 - b.x0 <= 1 && b.y1 - b.y0 <= 1) return;
    if (blocks_.is_predicted(b)) {
      filled_.push_back(b);
      blocks_.fill(b);
      return;
    }
    SharedBlocks::cut(b, next);
  }

  const BakeInput& input_;
  const GatherSettings& settings_;
  radiosity::GroupedLight& total_by_group_;
  BakeCounts& counts_;
  const Progress& progress_;
  const DimShares& dim_;
  NearTexels near_;
  radiosity::VirtualLights lights_;
  Gather::Aids aids_;
  Gather gather_;
  Guides guides_;
  NearLinks links_;
  GatheredMap map_;
  SharedBlocks blocks_;
  NearLinks::Start start_;
  std::vector<std::uint8_t> known_;  // texels whose light is there; empty: links not solved yet
  std::vector<Block> filled_;        // shared, coarse ones first
  std::vector<float> share_;         // of each texel in the rays, mean 1
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
