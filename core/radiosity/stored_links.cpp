#include "core/radiosity/stored_links.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/radiosity/element_rays.h"
#include "core/radiosity/hemisphere_walk.h"
#include "core/radiosity/resolved_light.h"

namespace lightbatch::radiosity {
namespace {

constexpr std::size_t kGrain = 256;

int ray_count(const Elements& elements, ElementId e, int rays) {
  return std::max(2, static_cast<int>(std::lround(rays * share_of_rays(elements, e))));
}

}  // namespace

Shot shoot(const SolverInput& input, const SolverOptions& options, const Solution& direct,
           RayCounts& counts, const Progress& progress) {
  const Elements& elements = input.elements;
  const bool sheets = input.optics.filtered_count() > 0;
  const std::size_t blocks = (elements.count() + kGrain - 1) / kGrain;
  struct Block {
    std::vector<ElementId> source;
    std::vector<Rgb> weight;
    std::vector<std::uint32_t> row;  // links of each element
    RayCounts counts;
  };
  std::vector<Block> block(blocks);
  Shot shot(input);
  Links& links = shot.links;
  links.scale.resize(elements.count());
  const auto near = static_cast<float>(1.5 * elements.edge());
  parallel_for(elements.count(), kGrain, [&](std::size_t begin, std::size_t end) {
    if (progress.cancelled()) return;
    Block& out = block[begin / kGrain];
    for (std::size_t i = begin; i < end; ++i) {
      const auto e = static_cast<ElementId>(i);
      const int rays = ray_count(elements, e, options.rays);
      links.scale[e] = 1.0f / static_cast<float>(rays);
      const OwenSobol8 sequence(static_cast<std::uint32_t>(item_seed(options.seed, e, 3)));
      const std::size_t before = out.source.size();
      const std::span<Rgb> by_group = shot.resolved_by_group.of(e);
      Rgbd from_sky, resolved;
      int near_hits = 0;
      for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(rays); ++k) {
        const auto [ray, triangle] = element_ray(input, e, sequence, k);
        const Vec3f& direction = ray.direction;
        walk_hemisphere_ray(
            input.optics, input.caster, ray, triangle, out.counts,
            [&](const rays::Hit& hit, const Rgb& weight) {
              if (hit.t < near) ++near_hits;
              ElementId source = input.lookup.at(hit);
              if (source == kNoElement) return;
              const Rgb sent = weight * elements.reflectance(source);
              const auto deliver = [&](std::uint32_t group, const Rgb& arrives) {
                if (!by_group.empty()) by_group[group] += sent * arrives * links.scale[e];
              };
              if (has_resolved(direct, source)) {
                const Rgb arrives = sharp_irradiance(input.scene, input.direct, direct, source, hit,
                                                     true, out.counts, deliver);
                resolved += to_double(sent * arrives);
              }
              // A cell of two rooms, of which this element is in one: it is taken to be as bright.
              if (input.lookup.is_split(source)) source = e;
              out.source.push_back(source);
              if (sheets) out.weight.push_back(weight);
            },
            [&](const Rgb& weight) {
              from_sky += to_double(weight * input.sky.radiance(direction));
            });
      }
      shot.resolved[e] = to_float(resolved / rays);
      shot.crowding[e] = static_cast<float>(near_hits) / static_cast<float>(rays);
      shot.sky[e] = to_float(from_sky * (kPiDouble / rays));
      out.row.push_back(static_cast<std::uint32_t>(out.source.size() - before));
    }
  });
  links.start.reserve(elements.count() + 1);
  links.start.push_back(0);
  std::uint64_t total = 0;
  for (const Block& b : block) total += b.source.size();
  links.source.reserve(total);
  if (sheets) links.weight.reserve(total);
  for (Block& b : block) {
    for (const std::uint32_t n : b.row) links.start.push_back(links.start.back() + n);
    links.source.insert(links.source.end(), b.source.begin(), b.source.end());
    links.weight.insert(links.weight.end(), b.weight.begin(), b.weight.end());
    counts += b.counts;
    b = Block{};
  }
  return shot;
}

}  // namespace lightbatch::radiosity
