#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/atlas/mask.h"

namespace lightbatch::atlas {

/// A mask as runs of set texels, ready to be searched a place for.
class Silhouette {
 public:
  explicit Silhouette(const Mask& mask);

  struct Run {
    int begin = 0, end = 0;
  };
  struct Row {
    int y = 0;
    int widest = 0;                     // longest run
    std::uint32_t first = 0, last = 0;  // into runs
  };
  int width = 0, height = 0;
  std::vector<Run> runs;
  std::vector<Row> rows;  // the widest one first, then far apart: misfits show early
};

/// Occupied cells of a stack of pages, one above the other, all of one width and height. Finds
/// the first free place, 64 columns at a time.
class Strip {
 public:
  Strip(int width, int page_height);

  struct Place {
    int x = 0, y = 0;  // y over all pages
  };
  /// First place, by row and then column, in rows from `start` on and below `stop`.
  std::optional<Place> find(const Silhouette& shape, int start, int stop);
  void occupy(const Mask& mask, int x, int y);

  int width() const { return width_; }
  int page_height() const { return page_height_; }

 private:
  void grow(int rows);
  std::uint64_t conflicts(const std::uint64_t* row, int x, int length) const;
  int longest_free(const std::uint64_t* row) const;

  int width_, page_height_;
  int rows_ = 0;
  std::size_t stride_;
  std::vector<std::uint64_t> bits_;
  std::vector<int> free_;  // per row: longest free run
};

}  // namespace lightbatch::atlas
