#include "core/optics/texture.h"

#include <algorithm>
#include <cmath>

#include "core/math/rgb.h"

namespace lightbatch::optics {
namespace {

const std::array<float, 256>& srgb_table() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = srgb_to_linear(static_cast<float>(i) / 255.0f);
    }
    return values;
  }();
  return table;
}

int wrap_texel(int i, int size, scene::Wrap wrap) {
  switch (wrap) {
    case scene::Wrap::kClamp:
      return std::clamp(i, 0, size - 1);
    case scene::Wrap::kMirror: {
      const int period = 2 * size;
      const int m = ((i % period) + period) % period;
      return m < size ? m : period - 1 - m;
    }
    case scene::Wrap::kRepeat:
      break;
  }
  return ((i % size) + size) % size;
}

/// Texel coordinates where int and float arithmetic are safe; uv beyond it repeats anyway.
float fold(double coordinate, int size, scene::Wrap wrap) {
  if (!std::isfinite(coordinate)) coordinate = 0;
  if (wrap == scene::Wrap::kClamp) {
    coordinate = std::clamp(coordinate, -1.0, 2.0);
  } else {
    const double period = wrap == scene::Wrap::kMirror ? 2 : 1;
    coordinate -= period * std::floor(coordinate / period);
  }
  return static_cast<float>(coordinate * size - 0.5);
}

}  // namespace

std::array<float, 4> sample_texture(const image::Image8& image, const scene::TextureSlot& slot,
                                    Vec2f uv, bool srgb) {
  const Vec2d t = transform_uv(slot, uv);
  float x = fold(t.x, image.width, slot.wrap_u);
  float y = fold(t.y, image.height, slot.wrap_v);
  if (slot.filter == scene::Filter::kNearest) {
    x = std::floor(x + 0.5f);
    y = std::floor(y + 0.5f);
  }
  const float fx = std::floor(x);
  const float fy = std::floor(y);
  const float ax = x - fx;
  const float ay = y - fy;
  const std::array<int, 2> xs{wrap_texel(static_cast<int>(fx), image.width, slot.wrap_u),
                              wrap_texel(static_cast<int>(fx) + 1, image.width, slot.wrap_u)};
  const std::array<int, 2> ys{wrap_texel(static_cast<int>(fy), image.height, slot.wrap_v),
                              wrap_texel(static_cast<int>(fy) + 1, image.height, slot.wrap_v)};
  const auto& table = srgb_table();
  std::array<float, 4> sum{};
  for (std::size_t j = 0; j < 2; ++j) {
    for (std::size_t i = 0; i < 2; ++i) {
      const float weight = (i == 0 ? 1 - ax : ax) * (j == 0 ? 1 - ay : ay);
      const std::uint8_t* p = image.pixel(xs[i], ys[j]);
      for (std::size_t c = 0; c < 4; ++c) {
        const float value = srgb && c < 3 ? table[p[c]] : static_cast<float>(p[c]) / 255.0f;
        sum[c] += weight * value;
      }
    }
  }
  return sum;
}

TextureRange::TextureRange(const image::Image8& image)
    : width_(image.width), height_(image.height) {
  Level base{image.width, image.height, {}};
  base.cells.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  for (std::size_t i = 0; i < base.cells.size(); ++i) {
    for (std::size_t c = 0; c < 4; ++c) {
      base.cells[i].lowest[c] = base.cells[i].highest[c] = image.rgba[4 * i + c];
    }
  }
  levels_.push_back(std::move(base));
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    const Level& fine = levels_.back();
    Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}};
    coarse.cells.resize(static_cast<std::size_t>(coarse.width) *
                        static_cast<std::size_t>(coarse.height));
    for (int y = 0; y < coarse.height; ++y) {
      for (int x = 0; x < coarse.width; ++x) {
        Range range{{255, 255, 255, 255}, {0, 0, 0, 0}};
        for (int j = 2 * y; j < std::min(2 * y + 2, fine.height); ++j) {
          for (int i = 2 * x; i < std::min(2 * x + 2, fine.width); ++i) {
            const Range& r = fine.cells[static_cast<std::size_t>(j * fine.width + i)];
            for (std::size_t c = 0; c < 4; ++c) {
              range.lowest[c] = std::min(range.lowest[c], r.lowest[c]);
              range.highest[c] = std::max(range.highest[c], r.highest[c]);
            }
          }
        }
        coarse.cells[static_cast<std::size_t>(y * coarse.width + x)] = range;
      }
    }
    levels_.push_back(std::move(coarse));
  }
}

void TextureRange::add(int level, int x0, int y0, int x1, int y1, Range& range) const {
  const Level& cells = levels_[static_cast<std::size_t>(level)];
  for (int y = y0 >> level; y <= y1 >> level; ++y) {
    for (int x = x0 >> level; x <= x1 >> level; ++x) {
      const Range& r = cells.cells[static_cast<std::size_t>(y * cells.width + x)];
      for (std::size_t c = 0; c < 4; ++c) {
        range.lowest[c] = std::min(range.lowest[c], r.lowest[c]);
        range.highest[c] = std::max(range.highest[c], r.highest[c]);
      }
    }
  }
}

TextureRange::Range TextureRange::over(const scene::TextureSlot& slot, Vec2d lower,
                                       Vec2d upper) const {
  Range range{{255, 255, 255, 255}, {0, 0, 0, 0}};
  // Per axis: one or two runs of texels, or everything when the box is wider than the image.
  struct Runs {
    std::array<std::array<int, 2>, 2> run{};
    std::size_t count = 0;
  };
  const auto runs = [](double low, double high, int size, scene::Wrap wrap) {
    Runs result;
    const bool everything =
        !(high - low < 1) || wrap == scene::Wrap::kMirror || !(std::fabs(low) < 1e6);
    if (everything) {
      result.run[result.count++] = {0, size - 1};
      return result;
    }
    const double shift = wrap == scene::Wrap::kRepeat ? std::floor(low) : 0;
    const int first = static_cast<int>(std::floor((low - shift) * size - 0.5));
    const int last = static_cast<int>(std::floor((high - shift) * size - 0.5)) + 1;
    if (wrap == scene::Wrap::kClamp) {
      result.run[result.count++] = {std::clamp(first, 0, size - 1), std::clamp(last, 0, size - 1)};
    } else if (last - first + 1 >= size) {
      result.run[result.count++] = {0, size - 1};
    } else {
      const int a = ((first % size) + size) % size;
      const int b = ((last % size) + size) % size;
      if (a <= b) {
        result.run[result.count++] = {a, b};
      } else {
        result.run[result.count++] = {a, size - 1};
        result.run[result.count++] = {0, b};
      }
    }
    return result;
  };
  const Runs xs = runs(lower.x, upper.x, width_, slot.wrap_u);
  const Runs ys = runs(lower.y, upper.y, height_, slot.wrap_v);
  for (std::size_t j = 0; j < ys.count; ++j) {
    for (std::size_t i = 0; i < xs.count; ++i) {
      const int x0 = xs.run[i][0], x1 = xs.run[i][1];
      const int y0 = ys.run[j][0], y1 = ys.run[j][1];
      int level = 0;
      while (level + 1 < static_cast<int>(levels_.size()) &&
             std::max(x1 - x0, y1 - y0) >> level > 4) {
        ++level;
      }
      add(level, x0, y0, x1, y1, range);
    }
  }
  return range;
}

}  // namespace lightbatch::optics
