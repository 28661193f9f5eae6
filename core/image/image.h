#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/math/rgb.h"

namespace lightbatch::image {

/// 8 bits a channel, four channels, row 0 on top (glTF v = 0), as stored (not linearised).
struct Image8 {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  // width * height * 4

  const std::uint8_t* pixel(int x, int y) const {
    return rgba.data() + 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                              static_cast<std::size_t>(x));
  }
};

/// Linear float RGB, row 0 on top.
struct ImageRgb {
  int width = 0;
  int height = 0;
  std::vector<Rgb> pixels;

  ImageRgb() = default;
  ImageRgb(int w, int h)
      : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
  Rgb& at(int x, int y) {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
  const Rgb& at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

}  // namespace lightbatch::image
