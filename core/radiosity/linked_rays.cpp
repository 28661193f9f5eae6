#include "core/radiosity/linked_rays.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/radiosity/element_rays.h"
#include "core/radiosity/hemisphere_walk.h"

namespace lightbatch::radiosity {
namespace {

constexpr std::size_t kGrain = 256;
/// Twice the stored-ray mode's: the near field and the row sums are all these rays decide.
constexpr int kRaysFactor = 2;
constexpr int kLeastRays = 8;

int ray_count(const Elements& elements, ElementId e, int rays) {
  return std::max(kLeastRays,
                  static_cast<int>(std::lround(kRaysFactor * rays * share_of_rays(elements, e))));
}

struct Meeting {
  std::uint32_t place;
  Rgb weight;
};

}  // namespace

float CosineRays::met(ElementId e, bool near_only) const {
  float sum = 0;
  for (auto k = start[e]; k < start[e + 1]; ++k) {
    if (!near_only || near[k] != 0) sum += weight_of(k).sum() / 3;
  }
  return sum * scale[e];
}

std::size_t CosineRays::memory_bytes() const {
  return start.capacity() * 8 + place.capacity() * 4 + weight.capacity() * sizeof(Rgb) +
         near.capacity() + scale.capacity() * 4 + sky.capacity() * sizeof(Rgb);
}

CosineRays shoot_cosine_rays(const SolverInput& input, const LinkTree& tree,
                             const SolverOptions& options, RayCounts& counts,
                             const Progress& progress) {
  const Elements& elements = input.elements;
  const bool sheets = input.optics.filtered_count() > 0;
  struct Block {
    std::vector<Meeting> meetings;
    std::vector<std::uint32_t> row;
    RayCounts counts;
  };
  std::vector<Block> blocks((elements.count() + kGrain - 1) / kGrain);
  CosineRays rays;
  rays.scale.resize(elements.count());
  rays.sky.resize(elements.count());
  parallel_for(elements.count(), kGrain, [&](std::size_t begin, std::size_t end) {
    Block& out = blocks[begin / kGrain];
    for (std::size_t i = begin; i < end; ++i) {
      if (progress.cancelled()) return;
      const auto e = static_cast<ElementId>(i);
      const int count = ray_count(elements, e, options.rays);
      const OwenSobol8 sequence(static_cast<std::uint32_t>(item_seed(options.seed, e, 5)));
      const std::size_t before = out.meetings.size();
      Rgbd sky;
      for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(count); ++k) {
        const auto [ray, triangle] = element_ray(input, e, sequence, k);
        const Vec3f& direction = ray.direction;
        walk_hemisphere_ray(
            input.optics, input.caster, ray, triangle, out.counts,
            [&](const rays::Hit& hit, const Rgb& weight) {
              const ElementId source = elements.at(hit.triangle, hit.u, hit.v, hit.back);
              if (source != kNoElement) out.meetings.push_back({tree.place(source), weight});
            },
            [&](const Rgb& weight) {
              if (!input.sky.is_black()) sky += to_double(weight * input.sky.radiance(direction));
            });
      }
      const auto row = out.meetings.begin() + static_cast<std::ptrdiff_t>(before);
      std::stable_sort(row, out.meetings.end(),
                       [](const Meeting& a, const Meeting& b) { return a.place < b.place; });
      rays.scale[e] = 1.0f / static_cast<float>(count);
      rays.sky[e] = to_float(sky * (kPiDouble / count));
      out.row.push_back(static_cast<std::uint32_t>(out.meetings.size() - before));
    }
  });
  rays.start.assign(1, 0);
  if (progress.cancelled()) return rays;
  for (const Block& block : blocks) {
    for (const std::uint32_t n : block.row) rays.start.push_back(rays.start.back() + n);
    for (const Meeting& m : block.meetings) {
      rays.place.push_back(m.place);
      if (sheets) rays.weight.push_back(m.weight);
    }
    counts += block.counts;
  }
  rays.near.assign(rays.place.size(), 0);
  return rays;
}

}  // namespace lightbatch::radiosity
