#include "core/atlas/pack.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <tuple>

#include "core/atlas/strip.h"

namespace lightbatch::atlas {
namespace {

constexpr int kNoStop = 1 << 30;

/// Cell size in texels that a mask is placed on: large charts lose little by a coarse grid.
int cell_of(const Mask& mask) {
  const int size = std::max(mask.width, mask.height);
  return size >= 512 ? 8 : size >= 192 ? 4 : size >= 64 ? 2 : 1;
}

/// Sizes that search alike: exact when small, then steps of a sixth.
int size_class(int size) {
  return size <= 12 ? size : 12 + static_cast<int>(std::floor(4 * std::log2(size / 12.0)));
}

/// Masks already prepared for one grid, in the turns that differ.
struct Turn {
  int quarters = 0;
  Mask mask;  // in cells
  Silhouette silhouette;
};

std::vector<Turn> distinct_turns(const Mask& mask, int cell, int width) {
  std::vector<Turn> turns;
  for (int q = 0; q < 4; ++q) {
    Mask m = coarsened(turned(mask, q), cell);
    if (m.width > width) continue;
    const bool known =
        std::any_of(turns.begin(), turns.end(), [&](const Turn& t) { return t.mask == m; });
    if (known) continue;
    Silhouette silhouette(m);
    turns.push_back({q, std::move(m), std::move(silhouette)});
  }
  return turns;
}

class Packer {
 public:
  Packer(std::span<const Mask* const> items, int page_size, int width)
      : items_(items), page_size_(page_size), fine_(width, page_size) {
    packing_.placements.resize(items.size());
  }

  bool run(const std::vector<std::size_t>& order, const Progress& progress) {
    std::size_t done = 0;
    for (const std::size_t item : order) {
      if (done++ % 64 == 0 && progress.cancelled()) return false;
      place(item);
    }
    finish();
    return true;
  }

  Packing take() { return std::move(packing_); }

 private:
  void place(std::size_t item) {
    const Mask& mask = *items_[item];
    const int cell = cell_of(mask);
    if (cell != cell_) {
      cell_ = cell;
      coarse_ = cell > 1 ? std::make_unique<Strip>(fine_, cell) : nullptr;
      starts_.clear();
      turns_of_ = nullptr;
    }
    Strip& strip = coarse_ ? *coarse_ : fine_;
    if (turns_of_ == nullptr || !(*turns_of_ == mask))
      turns_ = distinct_turns(mask, cell, strip.width());
    turns_of_ = &mask;
    const Turn* best = nullptr;
    Strip::Place at;
    int stop = kNoStop;  // of the upper edge
    for (const Turn& turn : turns_) {
      int& start = starts_[{size_class(turn.mask.width), size_class(turn.mask.height)}];
      const auto place = strip.find(turn.silhouette, start, stop - turn.mask.height);
      if (!place) continue;
      start = std::max(start, place->y);
      best = &turn;
      at = *place;
      stop = at.y + turn.mask.height;
    }
    LB_CHECK(best != nullptr, "a chart is larger than a page");
    if (coarse_) coarse_->occupy(best->mask, at.x, at.y);
    fine_.occupy(turned(mask, best->quarters), at.x * cell, at.y * cell);
    const int y = at.y * cell;
    packing_.placements[item] = {static_cast<std::uint32_t>(y / page_size_), at.x * cell,
                                 y % page_size_, best->quarters};
  }

  void finish() {
    for (std::size_t i = 0; i < items_.size(); ++i) {
      const Placement& p = packing_.placements[i];
      const bool across = p.turn % 2 == 1;
      if (p.page >= packing_.pages.size()) packing_.pages.resize(p.page + 1);
      Page& page = packing_.pages[p.page];
      page.width = std::max(page.width, p.x + (across ? items_[i]->height : items_[i]->width));
      page.height = std::max(page.height, p.y + (across ? items_[i]->width : items_[i]->height));
    }
  }

  std::span<const Mask* const> items_;
  const int page_size_;
  Strip fine_;
  std::unique_ptr<Strip> coarse_;
  int cell_ = 1;
  std::map<std::pair<int, int>, int> starts_;  // by size class: rows below are taken
  const Mask* turns_of_ = nullptr;
  std::vector<Turn> turns_;
  Packing packing_;
};

/// Page widths to try for one page: near the square, and as wide as the longest chart.
std::vector<int> candidate_widths(std::span<const Mask* const> items, int page_size,
                                  double texels) {
  const double square = std::sqrt(texels / 0.85);
  int longest = 1, thickest = 1;
  for (const Mask* m : items) {
    longest = std::max({longest, m->width, m->height});
    thickest = std::max(thickest, std::min(m->width, m->height));
  }
  const auto usable = [&](double w) {
    const int whole = (static_cast<int>(std::ceil(std::max<double>(w, thickest))) + 7) / 8 * 8;
    return std::min(whole, page_size);
  };
  if (square > page_size) return {page_size};
  std::vector<int> widths{usable(std::max<double>(square, longest))};
  if (items.size() < 2000) {
    for (const double w : {square, square * 1.15, square * 0.87}) widths.push_back(usable(w));
    std::sort(widths.begin(), widths.end());
    widths.erase(std::unique(widths.begin(), widths.end()), widths.end());
  }
  return widths;
}

}  // namespace

double Packing::texels() const {
  double sum = 0;
  for (const Page& p : pages) sum += static_cast<double>(p.width) * p.height;
  return sum;
}

Packing pack(std::span<const Mask* const> items, int page_size, int width,
             const Progress& progress) {
  double texels = 0;
  for (const Mask* m : items) texels += static_cast<double>(m->count());
  std::vector<std::size_t> order(items.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto key = [&](std::size_t i) {
    const Mask& m = *items[i];
    return std::tuple(-cell_of(m), -(m.width + m.height), -std::max(m.width, m.height), i);
  };
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return key(a) < key(b); });

  const std::vector<int> widths =
      width > 0 ? std::vector<int>{width} : candidate_widths(items, page_size, texels);
  Packing best;
  for (const int w : widths) {
    Packer packer(items, page_size, w);
    if (!packer.run(order, progress)) return {};
    Packing packing = packer.take();
    if (best.pages.empty() || packing.texels() < best.texels()) best = std::move(packing);
  }
  return best;
}

}  // namespace lightbatch::atlas
