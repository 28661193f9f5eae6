#include "core/atlas/strip.h"

#include <algorithm>
#include <bit>

namespace lightbatch::atlas {
namespace {

constexpr std::uint64_t kAll = ~std::uint64_t{0};

/// 64 bits from bit `at` on.
std::uint64_t fetch(const std::uint64_t* words, int at) {
  const std::size_t word = static_cast<std::size_t>(at) / 64;
  const int shift = at % 64;
  return shift == 0 ? words[word] : words[word] >> shift | words[word + 1] << (64 - shift);
}

/// First x' >= x whose bit is set (or clear), or width.
int next_bit(const std::uint64_t* words, int width, int x, bool set) {
  for (; x < width; x = (x | 63) + 1) {
    const std::uint64_t word = words[static_cast<std::size_t>(x) / 64];
    const std::uint64_t rest = (set ? word : ~word) >> (x % 64);
    if (rest != 0) return std::min(width, x + std::countr_zero(rest));
  }
  return width;
}

/// Bit x of the result: any of bits x .. x + length - 1 of (low, high); 0 < length <= 64.
std::uint64_t any_within(std::uint64_t low, std::uint64_t high, int length) {
  int done = 1;
  const auto widen = [&](int by) {
    if (by == 64) {
      low |= high;
    } else if (by > 0) {
      low |= low >> by | high << (64 - by);
      high |= high >> by;
    }
  };
  for (; 2 * done <= length; done *= 2) widen(done);
  widen(length - done);
  return low;
}

}  // namespace

Silhouette::Silhouette(const Mask& mask) : width(mask.width), height(mask.height) {
  std::vector<Row> in_order;
  for (int y = 0; y < height; ++y) {
    Row row;
    row.y = y;
    row.first = static_cast<std::uint32_t>(runs.size());
    for (int x = 0; x < width;) {
      const int begin = next_bit(mask.row(y), width, x, true);
      if (begin == width) break;
      x = next_bit(mask.row(y), width, begin, false);
      runs.push_back({begin, x});
      row.widest = std::max(row.widest, x - begin);
    }
    row.last = static_cast<std::uint32_t>(runs.size());
    in_order.push_back(row);
  }
  // Odd multiples of falling powers of two, from the widest row on, around the height.
  std::size_t start = 0;
  for (std::size_t r = 1; r < in_order.size(); ++r) {
    if (in_order[r].widest > in_order[start].widest) start = r;
  }
  const std::size_t count = in_order.size();
  rows.push_back(in_order[start]);
  for (std::size_t step = std::bit_ceil(count); step > 0; step /= 2) {
    for (std::size_t r = step; r < count; r += 2 * step) {
      const Row& row = in_order[(start + r) % count];
      if (row.widest > 0) rows.push_back(row);
    }
  }
}

Strip::Strip(int width, int page_height)
    : width_(width),
      page_height_(page_height),
      stride_((static_cast<std::size_t>(width) + 63) / 64 + 3) {}

void Strip::grow(int rows) {
  if (rows <= rows_) return;
  rows_ = rows;
  bits_.resize(stride_ * static_cast<std::size_t>(rows), 0);
  free_.resize(static_cast<std::size_t>(rows), width_);
}

int Strip::longest_free(const std::uint64_t* row) const {
  int longest = 0;
  for (int x = 0; x < width_;) {
    const int begin = next_bit(row, width_, x, false);
    x = next_bit(row, width_, begin, true);
    longest = std::max(longest, x - begin);
  }
  return longest;
}

void Strip::occupy(const Mask& mask, int x, int y) {
  grow(y + mask.height);
  const std::size_t word = static_cast<std::size_t>(x) / 64;
  const int shift = x % 64;
  for (int r = 0; r < mask.height; ++r) {
    std::uint64_t* row = bits_.data() + stride_ * static_cast<std::size_t>(y + r);
    const std::uint64_t* from = mask.row(r);
    for (std::size_t i = 0; i < mask.stride; ++i) {
      row[word + i] |= from[i] << shift;
      if (shift != 0) row[word + i + 1] |= from[i] >> (64 - shift);
    }
    free_[static_cast<std::size_t>(y + r)] = longest_free(row);
  }
}

/// Bit k: a run of `length` cells from column x + k on meets an occupied cell.
std::uint64_t Strip::conflicts(const std::uint64_t* row, int x, int length) const {
  if (length <= 64) return any_within(fetch(row, x), fetch(row, x + 64), length);
  std::uint64_t head = fetch(row, x);  // bit k: any cell from k to 63
  for (int s = 1; s < 64; s *= 2) head |= head >> s;
  int at = x + 64;
  for (; at + 64 <= x + length; at += 64) {
    if (fetch(row, at) != 0) return kAll;
  }
  std::uint64_t middle = at < x + length ? fetch(row, at) & (kAll >> (64 - (x + length - at))) : 0;
  if (middle != 0) return kAll;
  std::uint64_t tail = fetch(row, x + length) << 1;  // bit k: any of the k cells beyond
  for (int s = 1; s < 64; s *= 2) tail |= tail << s;
  return head | tail;
}

std::optional<Strip::Place> Strip::find(const Silhouette& shape, int start, int stop) {
  for (int y = start; y < stop; ++y) {
    if (y % page_height_ + shape.height > page_height_) {
      y += page_height_ - y % page_height_ - 1;
      continue;
    }
    grow(y + shape.height);
    bool roomy = true;
    for (const Silhouette::Row& row : shape.rows) {
      roomy = row.widest <= free_[static_cast<std::size_t>(y + row.y)];
      if (!roomy) break;
    }
    if (!roomy) continue;
    const int last = width_ - shape.width;
    for (int x = 0; x <= last; x += 64) {
      std::uint64_t open = last - x >= 63 ? kAll : (std::uint64_t{1} << (last - x + 1)) - 1;
      for (const Silhouette::Row& row : shape.rows) {
        const std::uint64_t* words = bits_.data() + stride_ * static_cast<std::size_t>(y + row.y);
        for (std::uint32_t i = row.first; i < row.last && open != 0; ++i) {
          const auto& [begin, end] = shape.runs[i];
          open &= ~conflicts(words, x + begin, end - begin);
        }
        if (open == 0) break;
      }
      if (open != 0) return Place{x + std::countr_zero(open), y};
    }
  }
  return std::nullopt;
}

}  // namespace lightbatch::atlas
