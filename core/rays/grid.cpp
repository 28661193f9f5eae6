#include "core/rays/grid.h"

#include <cmath>
#include <limits>

#include "core/rays/casting_costs.h"

namespace lightbatch::rays {
namespace {

constexpr float kMostCells = 256;  // along an axis
/// Flatter boxes count as this part of their longest side.
constexpr float kThinnest = 1.0f / 64;
constexpr float kCellsPerLeaf[] = {0.5f, 2, 8};

/// Surface area of so many cells side by side.
float block_area(const GridLayout& grid, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  const float dx = grid.width[0] * static_cast<float>(x),
              dy = grid.width[1] * static_cast<float>(y),
              dz = grid.width[2] * static_cast<float>(z);
  return 2 * (dx * dy + dy * dz + dz * dx);
}

/// What does not depend on the members.
float own_cost(const Aabb& box, const GridLayout& grid) {
  return box.area() * kGridCost +
         block_area(grid, 1, 1, 1) * kCellCost * static_cast<float>(grid.cell_count());
}

/// The cells that a member's box touches.
struct Block {
  std::array<std::uint32_t, 3> first, last;

  Block(const GridLayout& grid, const Aabb& box) {
    for (std::size_t k = 0; k < 3; ++k) {
      first[k] = grid.cell_of(k, box.lower[k]);
      last[k] = grid.cell_of(k, box.upper[k]);
    }
  }
  std::uint32_t extent(std::size_t k) const { return last[k] - first[k] + 1; }
};

/// A ray that meets the box meets cells, and blocks of cells, by their areas.
float expected_cost(const Aabb& box, const GridLayout& grid, std::span<const GridMember> members) {
  const float cell = block_area(grid, 1, 1, 1);
  float cost = own_cost(box, grid);
  for (const GridMember& member : members) {
    const Block block(grid, member.box);
    const std::uint32_t x = block.extent(0), y = block.extent(1), z = block.extent(2);
    cost += block_area(grid, x, y, z) *
                (kGridLeafCost + kTriangleCost * static_cast<float>(member.triangles)) +
            cell * kMemberCost * static_cast<float>(x * y * z);
  }
  return cost;
}

template <typename Body>
void each_cell(const GridLayout& grid, const Block& block, Body body) {
  for (std::uint32_t z = block.first[2]; z <= block.last[2]; ++z) {
    for (std::uint32_t y = block.first[1]; y <= block.last[1]; ++y) {
      for (std::uint32_t x = block.first[0]; x <= block.last[0]; ++x) {
        body((z * grid.cells[1] + y) * grid.cells[0] + x);
      }
    }
  }
}

}  // namespace

GridLayout::GridLayout(const Aabb& box, float count) {
  const Vec3f extent = box.extent();
  const float longest = std::max(extent.x, std::max(extent.y, extent.z));
  float volume = 1;
  for (std::size_t k = 0; k < 3; ++k) volume *= std::max(extent[k], longest * kThinnest) / longest;
  const float step = longest * std::cbrt(volume / count);
  for (std::size_t k = 0; k < 3; ++k) {
    const float number =
        step > 0 ? std::min(std::max(std::round(extent[k] / step), 1.0f), kMostCells) : 1.0f;
    const float scale = number / extent[k];
    const bool flat = !(extent[k] > 0 && scale < std::numeric_limits<float>::infinity());
    cells[k] = flat ? 1u : static_cast<std::uint32_t>(number);
    low[k] = box.lower[k];
    width[k] = extent[k] / static_cast<float>(cells[k]);
    per_unit[k] = flat ? 0.0f : scale;
  }
}

GridPlan plan_grid(const Aabb& box, std::span<const GridMember> members) {
  GridPlan best{GridLayout(box, 1), std::numeric_limits<float>::infinity()};
  for (const float density : kCellsPerLeaf) {
    const GridLayout layout(box, density * static_cast<float>(members.size()));
    const float cost = expected_cost(box, layout, members);
    if (cost < best.cost) best = {layout, cost};
  }
  return best;
}

float least_grid_cost(const Aabb& box, std::uint32_t leaves) {
  float least = std::numeric_limits<float>::infinity();
  for (const float density : kCellsPerLeaf) {
    const GridLayout layout(box, density * static_cast<float>(leaves));
    const float member =
        block_area(layout, 1, 1, 1) * (kGridLeafCost + kTriangleCost + kMemberCost);
    least = std::min(least, own_cost(box, layout) + member * static_cast<float>(leaves));
  }
  return least;
}

std::vector<std::uint32_t> fill_grid(const GridLayout& layout,
                                     std::span<const GridMember> members) {
  const std::size_t cells = layout.cell_count();
  std::vector<std::uint32_t> words(cells + 1);
  for (const GridMember& m : members) {
    each_cell(layout, Block(layout, m.box), [&](std::uint32_t cell) { ++words[cell]; });
  }
  std::uint32_t sum = 0;
  for (std::uint32_t& word : words) word = sum += word;  // ends first, beginnings when filled
  words.resize(words.size() + sum);
  for (std::size_t k = members.size(); k-- > 0;) {
    each_cell(layout, Block(layout, members[k].box),
              [&](std::uint32_t cell) { words[cells + 1 + --words[cell]] = members[k].word; });
  }
  return words;
}

}  // namespace lightbatch::rays
