// Importance sampling by what other rays found, on a grid over the hemisphere: Jensen 1995
// (Importance Driven Path Tracing using the Photon Map). Deviations: texels learn from the rays of
// texels around them instead of photons; cells hold mean squares, whose root is the density of
// least variance; a fixed part of the points stays even, and cells that few rays went through lean
// on the mean, so that no guide is much worse than none.
#include "core/lightmap/guide.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lightbatch::lightmap {
namespace {

constexpr std::size_t kEdge = GuideGrid::kEdge;
constexpr std::size_t kCells = GuideGrid::kCells;
/// Of the points, and their density, that stay even.
constexpr double kEven = 0.4;
/// Rays of mean light that each cell is taken to have had besides its own.
constexpr double kPrior = 2;
/// Weights of a cell and of those beside it, each way.
constexpr double kOwn = 4, kBeside = 1;
constexpr int kFewestTexels = 3;           // edge of a chart that has tiles
constexpr std::size_t kMostTogether = 64;  // texels without a tile

}  // namespace

std::size_t GuideGrid::cell(Vec2f square) {
  constexpr auto edge = static_cast<float>(kEdge);
  const auto x = std::min(kEdge - 1, static_cast<std::size_t>(square.x * edge));
  const auto y = std::min(kEdge - 1, static_cast<std::size_t>(square.y * edge));
  return x + kEdge * y;
}

GuideGrid& GuideGrid::operator+=(const GuideGrid& other) {
  for (std::size_t i = 0; i < kCells; ++i) squares[i] += other.squares[i];
  rays += other.rays;
  return *this;
}

Guide::Guide() = default;

// In double: the squares of faint light are no normal floats, and those of strong light close to
// the largest.
Guide::Guide(const GuideGrid& learned) {
  double all = 0;
  for (const float s : learned.squares) all += static_cast<double>(s);
  if (!(all > 0) || !std::isfinite(all)) return;
  even_ = false;
  const double mean = all / static_cast<double>(learned.rays);  // of squares
  // Rays of a cell, if even.
  const double each = static_cast<double>(learned.rays) / static_cast<double>(kCells);
  std::array<double, kCells> density;
  double sum = 0;
  for (std::size_t y = 0; y < kEdge; ++y) {
    for (std::size_t x = 0; x < kEdge; ++x) {
      double squares = 0, weight = 0;
      for (std::size_t j = y > 0 ? y - 1 : 0; j <= std::min(y + 1, kEdge - 1); ++j) {
        for (std::size_t i = x > 0 ? x - 1 : 0; i <= std::min(x + 1, kEdge - 1); ++i) {
          const double w = (i == x ? kOwn : kBeside) * (j == y ? kOwn : kBeside);
          squares += w * static_cast<double>(learned.squares[i + kEdge * j]);
          weight += w;
        }
      }
      // In rays of the cell itself.
      squares /= kOwn * kOwn;
      weight /= kOwn * kOwn;
      double& d = density[x + kEdge * y];
      d = std::sqrt((squares + kPrior * mean) / (weight * each + kPrior));
      sum += d;
    }
  }
  const double scale = (1 - kEven) * static_cast<double>(kCells) / sum;
  for (std::size_t y = 0; y < kEdge; ++y) {
    for (std::size_t x = 0; x < kEdge; ++x) {
      float& d = density_[x + kEdge * y];
      d = static_cast<float>(kEven + scale * density[x + kEdge * y]);
      row_[y] += d;
    }
    total_ += row_[y];
  }
}

Guide::Place Guide::place(Vec2f even) const {
  if (even_) return {even, 1};
  constexpr float kBelowOne = 1 - 0x1p-24f;
  const auto within = [=](float left, float width) {
    return std::clamp(left / width, 0.0f, kBelowOne);
  };
  float left = even.y * total_;
  std::size_t y = 0;
  while (y + 1 < kEdge && left >= row_[y]) left -= row_[y++];
  const float down = within(left, row_[y]);
  const float* density = density_.data() + kEdge * y;
  left = even.x * row_[y];
  std::size_t x = 0;
  while (x + 1 < kEdge && left >= density[x]) left -= density[x++];
  const float along = within(left, density[x]);
  constexpr auto edge = static_cast<float>(kEdge);
  return {{std::min((static_cast<float>(x) + along) / edge, kBelowOne),
           std::min((static_cast<float>(y) + down) / edge, kBelowOne)},
          total_ / (static_cast<float>(kCells) * density[x])};
}

Guides::Guides(const atlas::Layout& layout) : layout_(layout), chart_(layout.charts.size()) {
  std::uint32_t tiles = 0;
  for (std::uint32_t c = 0; c < chart_.size(); ++c) {
    const atlas::Chart& chart = layout.charts[c];
    if (chart.tiny || chart.width < kFewestTexels || chart.height < kFewestTexels) continue;
    const auto count = [](int texels) {
      return static_cast<std::uint32_t>((texels + kTile - 1) / kTile);
    };
    chart_[c] = {tiles, count(chart.width), count(chart.height)};
    tiles += chart_[c].columns * chart_[c].rows;
    chart_of_.resize(tiles, c);
  }
  grid_.resize(tiles);
}

std::uint32_t Guides::tile_of(const atlas::Texel& texel) const {
  const Rows& rows = chart_[texel.chart];
  const atlas::Chart& chart = layout_.charts[texel.chart];
  const int x = (texel.x - chart.x) / kTile, y = (texel.y - chart.y) / kTile;
  if (x < 0 || y < 0 || static_cast<std::uint32_t>(x) >= rows.columns ||
      static_cast<std::uint32_t>(y) >= rows.rows) {
    return kNoTile;
  }
  return rows.first + static_cast<std::uint32_t>(y) * rows.columns + static_cast<std::uint32_t>(x);
}

std::vector<Guides::Group> Guides::sort(const atlas::TexelMap& map,
                                        std::vector<std::uint32_t>& texels) const {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> by_tile(texels.size());
  for (std::size_t i = 0; i < texels.size(); ++i) {
    by_tile[i] = {tile_of(map.texels[texels[i]]), texels[i]};
  }
  std::sort(by_tile.begin(), by_tile.end());
  std::vector<Group> groups;
  for (std::size_t i = 0; i < by_tile.size(); ++i) {
    const auto [tile, texel] = by_tile[i];
    texels[i] = texel;
    const bool other = groups.empty() || groups.back().tile != tile ||
                       (tile == kNoTile && i - groups.back().begin >= kMostTogether);
    if (other) groups.push_back({i, i, tile});
    groups.back().end = i + 1;
  }
  return groups;
}

Guide Guides::guide(std::uint32_t tile) const {
  const Rows& rows = chart_[chart_of_[tile]];
  const std::uint32_t x = (tile - rows.first) % rows.columns,
                      y = (tile - rows.first) / rows.columns;
  GuideGrid sum;
  for (std::uint32_t j = y > 0 ? y - 1 : 0; j <= std::min(y + 1, rows.rows - 1); ++j) {
    for (std::uint32_t i = x > 0 ? x - 1 : 0; i <= std::min(x + 1, rows.columns - 1); ++i) {
      sum += grid_[rows.first + j * rows.columns + i];
    }
  }
  return Guide(sum);
}

}  // namespace lightbatch::lightmap
