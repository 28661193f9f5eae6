#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/atlas/layout.h"
#include "core/atlas/texels.h"
#include "core/math/vec.h"

namespace lightbatch::lightmap {

/// Where over a surface light comes from: cells of the unit square that cosine_hemisphere maps to
/// directions about the normal.
struct GuideGrid {
  static constexpr std::size_t kEdge = 16;
  static constexpr std::size_t kCells = kEdge * kEdge;
  static std::size_t cell(Vec2f square);

  std::array<float, kCells> squares{};  // of what rays brought, each over its density
  float rays = 0;

  GuideGrid& operator+=(const GuideGrid& other);
};

/// A density over the unit square, mean 1, constant in each cell and never small: points of any
/// sequence are moved to it, so that many go where much comes from.
class Guide {
 public:
  /// Even.
  Guide();
  /// In proportion to the root of the mean square that arrives through each cell and those beside
  /// it, for a part of the points; the others stay even. Few rays say little.
  explicit Guide(const GuideGrid& learned);

  struct Place {
    Vec2f square;
    float weight = 1;  // 1 over the density there
  };
  Place place(Vec2f even) const;

 private:
  static constexpr std::size_t kEdge = GuideGrid::kEdge;

  bool even_ = true;
  std::array<float, kEdge * kEdge> density_{};
  std::array<float, kEdge> row_{};  // sums of rows
  float total_ = 0;
};

/// What the rays of a map's texels have told so far, by squares of texels on a chart.
class Guides {
 public:
  static constexpr std::uint32_t kNoTile = 0xffffffffu;

  explicit Guides(const atlas::Layout& layout);

  /// kNoTile where a chart shares too little: tiny and thin ones.
  std::uint32_t tile_of(const atlas::Texel& texel) const;
  /// From the tile and those around it on its chart.
  Guide guide(std::uint32_t tile) const;
  void add(std::uint32_t tile, const GuideGrid& learned) { grid_[tile] += learned; }

  /// Texels of one tile, or some that have none: a range of a list.
  struct Group {
    std::size_t begin = 0, end = 0;
    std::uint32_t tile = kNoTile;
  };
  /// Sorts a list of texels by tile, then by number.
  std::vector<Group> sort(const atlas::TexelMap& map, std::vector<std::uint32_t>& texels) const;

 private:
  static constexpr int kTile = 8;  // texels

  /// Tiles of a chart, row by row.
  struct Rows {
    std::uint32_t first = 0, columns = 0, rows = 0;
  };
  const atlas::Layout& layout_;
  std::vector<Rows> chart_;
  std::vector<std::uint32_t> chart_of_;  // per tile
  std::vector<GuideGrid> grid_;
};

}  // namespace lightbatch::lightmap
