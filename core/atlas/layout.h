#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/progress.h"
#include "core/base/status.h"
#include "core/math/vec.h"
#include "core/scene/scene.h"

namespace lightbatch::atlas {

struct LayoutOptions {
  /// Asked density; 0: chosen so that all pages together hold about `default_texels`.
  double texels_per_metre = 0;
  double default_texels = 524288;
  /// Hard limit on texels in all pages: a larger ask is lowered to it (and said in the layout).
  double max_texels = 64e6;
  int page_size = 2048;  // largest page edge in texels, 64..8192
};

struct Chart {
  std::uint32_t page = 0;
  int x = 0, y = 0, width = 0, height = 0;  // texel rectangle, bilinear footprint included
  std::uint32_t object = 0;                 // an object that the chart's triangles belong to
  Vec3f normal;                             // projection axis, unit, world
  std::uint32_t triangle_count = 0;
  bool tiny = false;  // shares texels with other tiny charts of its cell and direction
};

struct Page {
  int width = 0;
  int height = 0;
};

/// Where every triangle lies in the lightmap. uv is in texels of the page (divide by the page's
/// size for TEXCOORD_1); texel (x, y) covers [x, x+1) x [y, y+1), row 0 is v = 0. No texel is in
/// the bilinear footprint of two charts (tiny ones aside).
struct Layout {
  double asked_texels_per_metre = 0;
  double texels_per_metre = 0;
  std::vector<Page> pages;
  std::vector<Chart> charts;
  std::vector<std::uint32_t> chart_of;   // per triangle; scene::kNone: no lightmap
  std::vector<std::array<Vec2f, 3>> uv;  // per triangle and corner
  double charted_area = 0;               // m2
  double utilisation = 0;                // UV area of triangles / texels of pages
  double out_of_density_area = 0;  // share of area outside +-30 % (charts at least 2 texels wide)
  std::uint64_t footprint_conflicts = 0;  // counted by an independent pass; must be 0
};

/// Charts and packs the triangles with lit[i] != 0. Deterministic. CANCELLED, INPUT_OVER_BUDGET.
Result<Layout> make_layout(const scene::Scene& scene, const std::vector<std::uint8_t>& lit,
                           const LayoutOptions& options, const Progress& progress);

}  // namespace lightbatch::atlas
