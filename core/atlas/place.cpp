#include "core/atlas/place.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"

namespace lightbatch::atlas {
namespace {

/// Packs the charts of a shape that is shown several times into one block, as wide as an equal
/// share of the page, so that blocks fill the page side by side.
void make_block(PlacedUse& use, int page_size, const Progress& progress) {
  std::vector<const Mask*> items;
  double texels = 0;
  int thickest = 1;
  for (const BlockChart& chart : use.block.charts) {
    items.push_back(&chart.mask);
    texels += static_cast<double>(chart.mask.count());
    thickest = std::max(thickest, std::min(chart.mask.width, chart.mask.height));
  }
  const double side = std::sqrt(texels / 0.85);
  if (side > page_size) return;
  const int columns = static_cast<int>(page_size / side);
  const int share = page_size / columns / 8 * 8;
  const int width = columns > 8 ? 0 : std::max(share, (thickest + 7) / 8 * 8);
  Packing packing = pack(items, page_size, width, progress);
  if (packing.pages.size() != 1) return;
  use.outline = Mask(packing.pages[0].width, packing.pages[0].height);
  for (std::size_t i = 0; i < items.size(); ++i) {
    const Placement& p = packing.placements[i];
    use.outline.add(turned(*items[i], p.turn), p.x, p.y);
  }
  use.inside = std::move(packing.placements);
}

}  // namespace

GridPoint placed_point(const GridPoint& p, const Placement& at, int width, int height) {
  const std::int32_t w = (width - 1) * kUnits, h = (height - 1) * kUnits;
  const GridPoint turned_point = at.turn == 0   ? p
                                 : at.turn == 1 ? GridPoint{h - p.y, p.x}
                                 : at.turn == 2 ? GridPoint{w - p.x, h - p.y}
                                                : GridPoint{p.y, w - p.x};
  return {turned_point.x + at.x * kUnits, turned_point.y + at.y * kUnits};
}

Placed place_charts(const std::vector<ChartedShape>& shapes, double density, int page_size,
                    const Progress& progress) {
  Placed placed;
  for (std::uint32_t s = 0; s < shapes.size(); ++s) {
    for (std::uint32_t u = 0; u < shapes[s].uses.size(); ++u) {
      PlacedUse use;
      use.shape = s;
      use.use = u;
      placed.uses.push_back(std::move(use));
    }
  }
  parallel_for(placed.uses.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && !progress.cancelled(); ++i) {
      PlacedUse& use = placed.uses[i];
      const ChartedShape& charted = shapes[use.shape];
      const ChartedShape::Use& group = charted.uses[use.use];
      ChartSet charts = charted.charts;
      split_charts(charted.mesh, density * group.scale, page_size, charts);
      use.block = raster_charts(charted.mesh, charts, density * group.scale, page_size);
      if (group.instances.size() > 1 && use.block.charts.size() > 1) {
        make_block(use, page_size, progress);
      }
    }
  });
  if (progress.cancelled()) return {};

  std::vector<const Mask*> items;
  for (PlacedUse& use : placed.uses) {
    const std::size_t instances = shapes[use.shape].uses[use.use].instances.size();
    const bool whole = !use.inside.empty();
    use.placements.resize(instances * (whole ? 1 : use.block.charts.size()));
    for (std::size_t i = 0; i < instances; ++i) {
      if (whole) {
        items.push_back(&use.outline);
      } else {
        for (const BlockChart& chart : use.block.charts) items.push_back(&chart.mask);
      }
    }
  }
  Packing packing = pack(items, page_size, 0, progress);
  if (progress.cancelled()) return {};
  std::size_t next = 0;
  for (PlacedUse& use : placed.uses) {
    for (Placement& p : use.placements) p = packing.placements[next++];
  }
  for (Page& page : packing.pages) {
    page.width = std::min((page.width + 3) / 4 * 4, page_size);
    page.height = std::min((page.height + 3) / 4 * 4, page_size);
  }
  placed.texels = packing.texels();
  placed.pages = std::move(packing.pages);
  return placed;
}

}  // namespace lightbatch::atlas
