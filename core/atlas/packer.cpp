#include "core/atlas/packer.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace lightbatch::atlas {
namespace {

constexpr int kNoStop = 1 << 30;

/// Sizes that search alike: exact when small, then steps of a fifth.
int size_class(int size) {
  return size <= 12 ? size : 12 + static_cast<int>(std::floor(4 * std::log2(size / 12.0)));
}

int cell_of(std::size_t level) { return 1 << level; }

}  // namespace

Packer::Packer(std::span<const Mask* const> items, int page_size, int width,
               const std::array<int, kLevels - 1>& sizes)
    : items_(items), page_size_(page_size), sizes_(sizes) {
  for (const Mask* mask : items) ++levels_[level_of(*mask)].left;
  for (std::size_t l = 0; l < kLevels; ++l) {
    if (levels_[l].left == 0) continue;
    levels_[l].strip.emplace(width / cell_of(l), page_size / cell_of(l));
  }
  packing_.placements.resize(items.size());
}

std::size_t Packer::level_of(const Mask& mask) const {
  const int size = std::max(mask.width, mask.height);
  std::size_t level = 0;
  while (level < sizes_.size() && size >= sizes_[level]) ++level;
  return level;
}

void Packer::prepare(const Mask& mask, std::size_t level) {
  const bool known = prepared_ != nullptr && *prepared_ == mask;
  prepared_ = &mask;
  if (known) return;
  turns_.clear();
  for (int q = 0; q < 4; ++q) {
    Mask m = coarsened(turned(mask, q), cell_of(level));
    if (m.width > levels_[level].strip->width()) continue;
    const bool same =
        std::any_of(turns_.begin(), turns_.end(), [&](const Turn& t) { return t.mask == m; });
    if (same) continue;
    Silhouette silhouette(m);
    turns_.push_back({q, std::move(m), std::move(silhouette)});
  }
}

void Packer::place(std::size_t item) {
  const Mask& mask = *items_[item];
  const std::size_t level = level_of(mask);
  Level& own = levels_[level];
  prepare(mask, level);
  const Turn* best = nullptr;
  Strip::Place at;
  int stop = kNoStop;  // of the upper edge
  for (const Turn& turn : turns_) {
    int& start = own.starts[{size_class(turn.mask.width), size_class(turn.mask.height)}];
    const auto found = own.strip->find(turn.silhouette, start, stop - turn.mask.height);
    if (!found) continue;
    start = std::max(start, found->y);
    best = &turn;
    at = *found;
    stop = at.y + turn.mask.height;
  }
  LB_CHECK(best != nullptr, "a chart is larger than a page");
  const int x = at.x * cell_of(level), y = at.y * cell_of(level);
  --own.left;
  const Mask fine = turned(mask, best->quarters);
  for (std::size_t l = 0; l < kLevels; ++l) {
    if (levels_[l].left == 0) continue;
    const int cell = cell_of(l);
    Mask shifted(fine.width + x % cell, fine.height + y % cell);
    shifted.add(fine, x % cell, y % cell);
    levels_[l].strip->occupy(coarsened(shifted, cell), x / cell, y / cell);
  }
  top_ = std::max<double>(top_, y + fine.height);
  packing_.placements[item] = {static_cast<std::uint32_t>(y / page_size_), x, y % page_size_,
                               best->quarters};
}

bool Packer::run(const std::vector<std::size_t>& order, double limit, const Progress& progress) {
  std::size_t done = 0;
  for (const std::size_t item : order) {
    if (done++ % 64 == 0 && progress.cancelled()) return false;
    place(item);
    if (top_ * (levels_[0].strip ? levels_[0].strip->width() : 1) > limit) return false;
  }
  finish();
  return true;
}

void Packer::finish() {
  for (std::size_t i = 0; i < items_.size(); ++i) {
    const Placement& p = packing_.placements[i];
    const bool across = p.turn % 2 == 1;
    if (p.page >= packing_.pages.size()) packing_.pages.resize(p.page + 1);
    Page& page = packing_.pages[p.page];
    page.width = std::max(page.width, p.x + (across ? items_[i]->height : items_[i]->width));
    page.height = std::max(page.height, p.y + (across ? items_[i]->width : items_[i]->height));
  }
}

}  // namespace lightbatch::atlas
