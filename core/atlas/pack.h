#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/atlas/layout.h"
#include "core/atlas/mask.h"

namespace lightbatch::atlas {

/// Where a mask went: turned counter-clockwise by `turn` quarters, its corner at texel (x, y).
struct Placement {
  std::uint32_t page = 0;
  int x = 0, y = 0;
  int turn = 0;
};

struct Packing {
  std::vector<Placement> placements;  // per item
  std::vector<Page> pages;            // as small as the masks allow

  double texels() const;
};

/// Packs silhouettes without overlap on pages of at most page_size texels a side (a multiple of
/// 8); width 0: chosen. No mask may be longer than page_size. Empty when cancelled.
Packing pack(std::span<const Mask* const> items, int page_size, int width,
             const Progress& progress);

}  // namespace lightbatch::atlas
