#include "core/atlas/layout.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/atlas/place.h"
#include "core/atlas/verify.h"
#include "core/base/parallel.h"

namespace lightbatch::atlas {
namespace {

using scene::kNone;

Status check_options(const scene::Scene& scene, const std::vector<std::uint8_t>& lit,
                     const LayoutOptions& o) {
  LB_CHECK(lit.size() == scene.triangles.size(), "one lit flag for each triangle");
  if (!std::isfinite(o.texels_per_metre) || o.texels_per_metre < 0) {
    return bad_option("texels per metre must be 0 (automatic) or a positive number");
  }
  if (!(o.default_texels >= 1) || !(o.max_texels >= 1)) {
    return bad_option("the number of lightmap texels must be at least 1");
  }
  if (o.page_size < 64 || o.page_size > 8192) {
    return bad_option("the lightmap page size must be between 64 and 8192 texels");
  }
  return {};
}

/// Shapes with charts. `asked` 0: the density that steers the choice of charts is guessed.
std::vector<ChartedShape> chart_shapes(const scene::Scene& scene,
                                       const std::vector<std::uint8_t>& lit,
                                       const LayoutOptions& options, int max_side,
                                       const Progress& progress) {
  std::vector<ChartedShape> charted;
  for (Shape& shape : find_shapes(scene, lit)) charted.emplace_back().shape = std::move(shape);
  parallel_for(charted.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end && !progress.cancelled(); ++s) {
      charted[s].mesh = weld(scene, charted[s].shape.triangles);
      charted[s].uses = group_by_scale(charted[s].shape);
    }
  });
  std::erase_if(charted, [](const ChartedShape& c) { return c.mesh.size() == 0; });
  double area = 0;
  for (const ChartedShape& c : charted) area += c.area();
  double guess = options.texels_per_metre;
  const double most =
      guess > 0 ? options.max_texels : std::min(options.default_texels, options.max_texels);
  if (guess == 0 || area * guess * guess > most) guess = std::sqrt(0.75 * most / area);
  parallel_for(charted.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end && !progress.cancelled(); ++s) {
      ChartedShape& c = charted[s];
      c.charts = make_charts(c.mesh, c.shape.frame, guess * c.uses[0].scale, max_side);
    }
  });
  return charted;
}

/// Places at the asked density, or at the one whose pages hold the wanted number of texels.
Result<Placed> place_at_density(const std::vector<ChartedShape>& shapes,
                                const LayoutOptions& options, int page_size, Layout& layout,
                                const Progress& progress) {
  double area = 0;
  for (const ChartedShape& c : shapes) area += c.area();
  const bool automatic = options.texels_per_metre == 0;
  const double wanted = std::min(options.default_texels, options.max_texels);
  double highest = options.texels_per_metre;
  if (automatic) highest = 16 * std::sqrt(wanted / area);
  double target = automatic ? wanted : options.max_texels;
  double density = solve_density(shapes, target, highest, page_size);
  constexpr int kRounds = 8;
  for (int round = 0; round < kRounds; ++round) {
    progress.report("pack", static_cast<double>(round) / kRounds);
    Placed placed = place_charts(shapes, density, page_size, progress);
    if (progress.cancelled()) return cancelled();
    const bool fits = placed.texels <= options.max_texels;
    const bool full = placed.texels >= 0.93 * wanted || density >= highest;
    const bool close = !automatic || (full && placed.texels <= 1.07 * wanted);
    if (fits && (close || round >= 2)) {
      layout.texels_per_metre = density;
      return placed;
    }
    // The estimate was off by this factor: aim beside the target by as much.
    const double expected = texels_estimate(shapes, density, page_size);
    const double aim = (fits ? 1.0 : 0.97) * target * expected / placed.texels;
    const double next = solve_density(shapes, aim, highest, page_size);
    density = fits ? next : std::min(next, density * 0.95);
  }
  return over_budget("", "the lightmap needs more than " + std::to_string(options.max_texels) +
                             " texels even at the lowest density; allow more texels or fewer "
                             "objects with lightmaps");
}

/// Writes coordinates and charts of all instances of one placed use.
void write_use(const scene::Scene& scene, const ChartedShape& charted, const PlacedUse& use,
               std::uint32_t first_chart, Layout& layout, std::vector<bool>& wide) {
  const auto& instances = charted.uses[use.use].instances;
  const std::size_t count = use.block.charts.size();
  const bool whole = !use.inside.empty();
  for (std::size_t i = 0; i < instances.size(); ++i) {
    const Instance& instance = charted.shape.instances[instances[i]];
    const std::uint32_t base = first_chart + static_cast<std::uint32_t>(i * count);
    const auto to_page = [&](std::size_t c, GridPoint p) {
      const Mask& mask = use.block.charts[c].mask;
      if (!whole) return placed_point(p, use.placements[i * count + c], mask.width, mask.height);
      p = placed_point(p, use.inside[c], mask.width, mask.height);
      return placed_point(p, use.placements[i], use.outline.width, use.outline.height);
    };
    for (std::size_t c = 0; c < count; ++c) {
      const BlockChart& from = use.block.charts[c];
      Chart& to = layout.charts[base + c];
      const GridPoint a = to_page(c, {0, 0});
      const GridPoint b =
          to_page(c, {(from.mask.width - 1) * kUnits, (from.mask.height - 1) * kUnits});
      to.page = use.placements[whole ? i : i * count + c].page;
      to.x = std::min(a.x, b.x) / kUnits;
      to.y = std::min(a.y, b.y) / kUnits;
      to.width = std::abs(a.x - b.x) / kUnits + 1;
      to.height = std::abs(a.y - b.y) / kUnits + 1;
      to.normal = to_float(normalized(instance.move.normal(to_double(from.axis))));
      to.tiny = from.tiny;
      wide[base + c] = from.wide;
    }
    for (std::uint32_t m = 0; m < charted.mesh.size(); ++m) {
      const std::uint32_t t = instance.triangles[charted.mesh.source[m]];
      if (t == kNone) continue;
      const std::uint32_t c = use.block.chart_of[m];
      Chart& chart = layout.charts[base + c];
      if (chart.triangle_count++ == 0) chart.object = scene.triangles[t].object;
      layout.chart_of[t] = base + c;
      for (std::size_t k = 0; k < 3; ++k) {
        const GridPoint p = to_page(c, use.block.uv[m][k]);
        layout.uv[t][instance.order[k]] = {static_cast<float>(p.x + kUnits / 2) / kUnits,
                                           static_cast<float>(p.y + kUnits / 2) / kUnits};
      }
    }
  }
}

}  // namespace

Result<Layout> make_layout(const scene::Scene& scene, const std::vector<std::uint8_t>& lit,
                           const LayoutOptions& options, const Progress& progress) {
  LB_RETURN_IF_ERROR(check_options(scene, lit, options));
  Layout layout;
  layout.asked_texels_per_metre = options.texels_per_metre;
  layout.chart_of.assign(scene.triangles.size(), kNone);
  layout.uv.resize(scene.triangles.size());
  const int page_size = options.page_size / 8 * 8;

  progress.report("charts", 0);
  const std::vector<ChartedShape> shapes = chart_shapes(scene, lit, options, page_size, progress);
  if (progress.cancelled()) return cancelled();
  if (shapes.empty()) return layout;
  LB_ASSIGN_OR_RETURN(Placed placed,
                      place_at_density(shapes, options, page_size, layout, progress));

  layout.pages = placed.pages;
  std::size_t charts = 0;
  for (const PlacedUse& use : placed.uses) {
    charts += use.block.charts.size() * shapes[use.shape].uses[use.use].instances.size();
  }
  layout.charts.resize(charts);
  std::vector<bool> wide(charts);
  std::uint32_t next = 0;
  for (const PlacedUse& use : placed.uses) {
    write_use(scene, shapes[use.shape], use, next, layout, wide);
    next += static_cast<std::uint32_t>(use.block.charts.size() *
                                       shapes[use.shape].uses[use.use].instances.size());
  }
  progress.report("verify", 0);
  layout.footprint_conflicts = count_conflicts(layout);
  measure(scene, wide, layout);
  return layout;
}

}  // namespace lightbatch::atlas
