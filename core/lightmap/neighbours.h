#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/atlas/layout.h"
#include "core/atlas/texels.h"
#include "core/scene/scene.h"

namespace lightbatch::lightmap {

/// The texel of a chart at a place inside its page; kNone where another's is, or none.
inline std::uint32_t texel_at(const atlas::TexelMap& map, const atlas::Layout& layout,
                              std::uint32_t chart, int x, int y) {
  const auto page = static_cast<std::size_t>(layout.charts[chart].page);
  const std::uint32_t t =
      map.index[page][static_cast<std::size_t>(y * layout.pages[page].width + x)];
  return t != scene::kNone && map.texels[t].chart == chart ? t : scene::kNone;
}

/// The texel itself (at 4) and the eight around it at `step` texels in its own chart, row by row;
/// kNone where there is none. Opposite neighbours are k and 8 - k.
inline std::array<std::uint32_t, 9> neighbourhood(const atlas::TexelMap& map,
                                                  const atlas::Layout& layout, std::uint32_t t,
                                                  int step = 1) {
  std::array<std::uint32_t, 9> at;
  at.fill(scene::kNone);
  const atlas::Texel& texel = map.texels[t];
  const atlas::Page& page = layout.pages[texel.page];
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const int x = texel.x + step * dx;
      const int y = texel.y + step * dy;
      if (x < 0 || y < 0 || x >= page.width || y >= page.height) continue;
      at[static_cast<std::size_t>(3 * (dy + 1) + dx + 1)] =
          texel_at(map, layout, texel.chart, x, y);
    }
  }
  at[4] = t;
  return at;
}

}  // namespace lightbatch::lightmap
