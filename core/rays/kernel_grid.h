// A ray through a regular grid; included by kernel_impl.h only.
//
// I. Wald, T. Ike, A. Kensler, A. Knoll, S. Parker: Ray Tracing Animated Scenes using Coherent Grid
// Traversal, SIGGRAPH 2006: slice by slice along the axis on which the ray runs fastest, in each
// slice all cells that it may touch. Here for one ray and conservatively: ranges are widened by
// more than any rounding, where a walk from cell to cell could miss one.

/// Calls visit(leaf) for members that the ray may meet at distances from `lower` to `upper`, nearer
/// slices first, none twice in short order; until visit returns true. `upper` may fall meanwhile.
template <typename Visit>
LB_INLINE bool walk_grid(const Grid& grid, const BoxRay& r, float lower, const float& upper,
                         Visit visit) {
  const GridLayout& g = grid.layout;
  const float slack = r.span * 0x1p-19f + 1e-36f;
  const float dz = 1 / r.sz;
  // Where the ray is on its main axis while it is inside the grid's box.
  float from = lower, to = upper;
  for (std::size_t k = 0; k < 3; ++k) {
    const float low = g.low[k] - slack;
    const float high = g.low[k] + g.width[k] * static_cast<float>(g.cells[k]) + slack;
    const bool backward = r.near_plane[k] >= 3 * kWidth;
    from = std::max(from, (backward ? high : low) * r.inverse[k] + r.near_offset[k]);
    to = std::min(to, (backward ? low : high) * r.inverse[k] + r.far_offset[k]);
  }
  if (!(from <= to)) return false;
  const float z_from = r.oz + from * dz, z_to = r.oz + to * dz;
  const float z_low = std::min(z_from, z_to) - slack, z_high = std::max(z_from, z_to) + slack;
  const std::uint32_t lowest_slice = g.cell_of(r.kz, z_low), last_slice = g.cell_of(r.kz, z_high);
  const std::size_t stride[3] = {1, g.cells[0], std::size_t{g.cells[0]} * g.cells[1]};
  const std::uint32_t* starts = grid.starts();
  const std::uint32_t* members = grid.members();
  constexpr std::size_t kSeen = 16;
  std::uint32_t seen[kSeen] = {};  // no leaf's reference is 0
  const std::uint32_t slices = last_slice - lowest_slice + 1;
  for (std::uint32_t i = 0; i < slices; ++i) {
    const std::uint32_t slice = r.sz > 0 ? lowest_slice + i : last_slice - i;
    const float begin = g.low[r.kz] + g.width[r.kz] * static_cast<float>(slice);
    const float z0 = std::max(z_low, begin - slack) - r.oz;
    const float z1 = std::min(z_high, begin + g.width[r.kz] + slack) - r.oz;
    if ((r.sz > 0 ? z0 - slack : z1 + slack) * r.sz > upper) return false;
    const float x0 = r.ox + r.sx * z0, x1 = r.ox + r.sx * z1;
    const float y0 = r.oy + r.sy * z0, y1 = r.oy + r.sy * z1;
    const std::uint32_t first_x = g.cell_of(r.kx, std::min(x0, x1) - slack),
                        last_x = g.cell_of(r.kx, std::max(x0, x1) + slack),
                        first_y = g.cell_of(r.ky, std::min(y0, y1) - slack),
                        last_y = g.cell_of(r.ky, std::max(y0, y1) + slack);
    for (std::uint32_t y = first_y; y <= last_y; ++y) {
      for (std::uint32_t x = first_x; x <= last_x; ++x) {
        const std::size_t cell = slice * stride[r.kz] + y * stride[r.ky] + x * stride[r.kx];
        for (std::uint32_t m = starts[cell]; m < starts[cell + 1]; ++m) {
          const std::uint32_t leaf = members[m];
          if (seen[leaf % kSeen] == leaf) continue;
          seen[leaf % kSeen] = leaf;
          if (visit(leaf)) return true;
        }
      }
    }
  }
  return false;
}
