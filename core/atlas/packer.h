#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/atlas/pack.h"
#include "core/atlas/strip.h"

namespace lightbatch::atlas {

/// Cell sizes that masks are placed on: 1, 2, 4 or 8 texels. Large charts lose little on a coarse
/// grid and are found a place for much sooner.
constexpr std::size_t kLevels = 4;

/// Places masks one by one, each at the first free place (by upper edge) over its four turns.
class Packer {
 public:
  /// sizes: a mask whose longer side reaches sizes[l - 1] texels is placed on level l.
  Packer(std::span<const Mask* const> items, int page_size, int width,
         const std::array<int, kLevels - 1>& sizes);

  /// False when cancelled, or as soon as the pages hold more than `limit` texels.
  bool run(const std::vector<std::size_t>& order, double limit, const Progress& progress);

  Packing take() { return std::move(packing_); }

 private:
  struct Turn {
    int quarters = 0;
    Mask mask;  // in cells
    Silhouette silhouette;
  };
  struct Level {
    std::optional<Strip> strip;                 // absent when no mask is placed on it
    std::size_t left = 0;                       // masks still to be placed on it
    std::map<std::pair<int, int>, int> starts;  // by size class: rows below are taken
  };

  std::size_t level_of(const Mask& mask) const;
  void prepare(const Mask& mask, std::size_t level);
  void place(std::size_t item);
  void finish();

  std::span<const Mask* const> items_;
  const int page_size_;
  const std::array<int, kLevels - 1> sizes_;
  std::array<Level, kLevels> levels_;
  const Mask* prepared_ = nullptr;
  std::vector<Turn> turns_;  // of the prepared mask, those that differ
  double top_ = 0;           // rows in use over all pages
  Packing packing_;
};

}  // namespace lightbatch::atlas
