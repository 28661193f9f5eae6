#include <algorithm>
#include <cmath>

#include "core/atlas/fragments.h"
#include "core/atlas/texels.h"
#include "core/atlas/verify.h"
#include "core/base/parallel.h"

namespace lightbatch::atlas {
namespace {

using scene::kNone;

constexpr std::int32_t kBandRows = 32;

/// Rows of one page that are covered together; bands do not share texels.
struct Band {
  std::uint32_t page = 0;
  std::int32_t first_row = 0, end_row = 0;
  std::vector<std::uint32_t> triangles;
  std::vector<Texel> texels;        // first_fragment counts within the band
  std::vector<Fragment> fragments;  // by texel, then in the order of triangles
};

std::vector<Band> make_bands(const Layout& layout) {
  std::vector<Band> bands;
  std::vector<std::size_t> first_band;
  for (std::uint32_t p = 0; p < layout.pages.size(); ++p) {
    first_band.push_back(bands.size());
    for (std::int32_t y = 0; y < layout.pages[p].height; y += kBandRows) {
      bands.push_back({p, y, std::min(y + kBandRows, layout.pages[p].height), {}, {}, {}});
    }
  }
  for (std::uint32_t t = 0; t < layout.chart_of.size(); ++t) {
    if (layout.chart_of[t] == kNone) continue;
    const std::uint32_t page = layout.charts[layout.chart_of[t]].page;
    const RowRange rows = texel_rows(grid_triangle(layout, t));
    const std::int32_t last_row = std::min(rows.last, layout.pages[page].height - 1);
    for (std::int32_t b = std::max(rows.first, 0) / kBandRows; b * kBandRows <= last_row; ++b) {
      bands[first_band[page] + static_cast<std::size_t>(b)].triangles.push_back(t);
    }
  }
  return bands;
}

void cover_band(const scene::Scene& scene, const Layout& layout, Band& band) {
  std::vector<PlacedFragment> found;
  for (const std::uint32_t t : band.triangles) {
    append_fragments(grid_triangle(layout, t), t, scene.area(t), band.first_row, band.end_row,
                     found);
  }
  const std::int32_t columns = layout.pages[band.page].width;
  std::erase_if(found, [&](const PlacedFragment& f) { return f.x < 0 || f.x >= columns; });
  // Stable counting sort by texel.
  const auto width = static_cast<std::size_t>(columns);
  const auto texel_of = [&](const PlacedFragment& f) {
    return static_cast<std::size_t>(f.y - band.first_row) * width + static_cast<std::size_t>(f.x);
  };
  const std::size_t size = width * static_cast<std::size_t>(band.end_row - band.first_row);
  std::vector<std::uint32_t> place(size + 1, 0);
  for (const PlacedFragment& f : found) ++place[texel_of(f) + 1];
  for (std::size_t i = 0; i < size; ++i) {
    const std::uint32_t count = place[i + 1];
    if (count > 0) {
      Texel texel;
      texel.page = static_cast<std::uint16_t>(band.page);
      texel.x = static_cast<std::uint16_t>(i % width);
      texel.y = static_cast<std::uint16_t>(static_cast<std::size_t>(band.first_row) + i / width);
      texel.fragment_count = count;
      texel.first_fragment = place[i];
      band.texels.push_back(texel);
    }
    place[i + 1] += place[i];
  }
  band.fragments.resize(found.size());
  for (const PlacedFragment& f : found) band.fragments[place[texel_of(f)]++] = f.fragment;
  for (Texel& texel : band.texels) {
    double coverage = 0;
    for (std::uint32_t i = 0; i < texel.fragment_count; ++i) {
      coverage += static_cast<double>(band.fragments[texel.first_fragment + i].area);
    }
    texel.coverage = static_cast<float>(coverage);
    texel.chart = layout.chart_of[band.fragments[texel.first_fragment].triangle];
  }
  band.triangles = {};
}

}  // namespace

TexelMap cover_texels(const scene::Scene& scene, const Layout& layout) {
  std::vector<Band> bands = make_bands(layout);
  parallel_for(bands.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) cover_band(scene, layout, bands[b]);
  });

  TexelMap map;
  for (const Page& page : layout.pages) {
    map.index.emplace_back(
        static_cast<std::size_t>(page.width) * static_cast<std::size_t>(page.height), kNone);
  }
  std::size_t texels = 0, fragments = 0;
  for (const Band& band : bands) {
    texels += band.texels.size();
    fragments += band.fragments.size();
  }
  map.texels.reserve(texels);
  map.fragments.reserve(fragments);
  for (Band& band : bands) {
    const auto width = static_cast<std::size_t>(layout.pages[band.page].width);
    const auto base = static_cast<std::uint32_t>(map.fragments.size());
    for (Texel texel : band.texels) {
      texel.first_fragment += base;
      map.index[band.page][texel.y * width + texel.x] =
          static_cast<std::uint32_t>(map.texels.size());
      map.texels.push_back(texel);
    }
    map.fragments.insert(map.fragments.end(), band.fragments.begin(), band.fragments.end());
    band = {};
  }
  return map;
}

PageTriangle::PageTriangle(const Layout& layout, std::uint32_t triangle)
    : triangle_(triangle),
      corner_(grid_triangle(layout, triangle)),
      twice_area_(atlas::twice_area(corner_)) {}

SurfacePoint PageTriangle::at(Vec2f page_uv) const {
  const GridTriangle& g = corner_;
  const double x = static_cast<double>(page_uv.x) * kUnits;
  const double y = static_cast<double>(page_uv.y) * kUnits;
  double weight[3] = {1.0 / 3, 1.0 / 3, 1.0 / 3};
  if (twice_area_ != 0) {
    for (std::size_t k = 0; k < 3; ++k) {
      const GridPoint &a = g[(k + 1) % 3], &b = g[(k + 2) % 3];
      weight[k] =
          ((a.x - x) * (b.y - y) - (b.x - x) * (a.y - y)) / static_cast<double>(twice_area_);
      weight[k] = std::max(weight[k], 0.0);
    }
    const double sum = weight[0] + weight[1] + weight[2];
    for (double& w : weight) w /= sum;
  } else if (const CollapsedTriangle line(g); !line.point) {
    const GridPoint &a = g[line.order[0]], &b = g[line.order[2]];
    const double dx = b.x - a.x, dy = b.y - a.y;
    const double t = std::clamp(((x - a.x) * dx + (y - a.y) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
    // Half way between the points at t on the long side and on the two short ones.
    const bool before = t < line.middle;
    const double span = before ? line.middle : 1 - line.middle;
    const double along = span > 0 ? (before ? t / line.middle : (1 - t) / span) : 1.0;
    weight[line.order[0]] = (1 - t) / 2 + (before ? (1 - along) / 2 : 0.0);
    weight[line.order[1]] = along / 2;
    weight[line.order[2]] = t / 2 + (before ? 0.0 : (1 - along) / 2);
  }
  SurfacePoint point;
  point.triangle = triangle_;
  point.u = static_cast<float>(weight[1]);
  point.v = static_cast<float>(weight[2]);
  return point;
}

}  // namespace lightbatch::atlas
