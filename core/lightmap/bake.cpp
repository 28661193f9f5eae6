#include "core/lightmap/bake.h"

#include "core/base/random.h"
#include "core/lightmap/blocks.h"
#include "core/lightmap/dim.h"
#include "core/lightmap/neighbours.h"
#include "core/scene/scene.h"

namespace lightbatch::lightmap {

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
    for (int y = b.y0; y <= b.y1; ++y) {
      for (int x = b.x0; x <= b.x1; ++x) {
        const std::uint32_t t = texel_at(map, layout, b.chart, x, y);
        if (t != scene::kNone && mark[t] == kFree) mark[t] = chosen;
      }
    }
  });
  for (std::uint32_t t = 0; t < mark.size(); ++t) {
    if (mark[t] == kFree) mark[t] = item_seed(0x7e6e1, t) % divisor == 0 ? kSelected : kPassedOver;
    mark[t] = mark[t] == kSelected ? 1 : 0;
  }
  return mark;
}

Result<BakedTexels> bake_texels(const BakeInput& input, const GatherSettings& settings,
                                const Progress& progress) {
  BakedTexels baked;
  baked.counts.texels = input.texels.texels.size();
  const DimShares dim(input, settings);
  progress.report("direct", 0);
  baked.by_group =
      radiosity::GroupedLight(input.groups > 0 ? input.texels.texels.size() : 0, input.groups);
  baked.direct = bake_direct(input, settings, dim, baked.by_group, baked.counts, progress,
                             &baked.direct_seconds);
  baked.direct_rays = baked.counts.rays.cast();
  if (progress.cancelled()) return cancelled();
  progress.report("gather", 0);
  baked.irradiance = bake_indirect(input, settings, dim, baked.by_group, baked.counts, progress,
                                   &baked.gather_seconds);
  if (progress.cancelled()) return cancelled();
  for (std::size_t t = 0; t < baked.direct.size(); ++t) baked.irradiance[t] += baked.direct[t];
  return baked;
}

}  // namespace lightbatch::lightmap
