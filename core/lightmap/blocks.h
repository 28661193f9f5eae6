#pragma once

#include <algorithm>
#include <cstdint>

#include "core/atlas/layout.h"

namespace lightbatch::lightmap {

/// Texel rectangle with computed corners, both ends included, in page coordinates.
struct Block {
  std::uint32_t chart = 0;
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// The blocks of a layout, `step` texels wide, chart by chart. Tiny and thin charts have none.
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
        visit(Block{c, x, y, std::min(x + step, x_last), std::min(y + step, y_last)});
      }
    }
  }
}

}  // namespace lightbatch::lightmap
