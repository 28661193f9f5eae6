#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/base/random.h"
#include "core/hierarchy/isometric.h"
#include "core/hierarchy/level_boxes.h"

namespace lightbatch::hierarchy {
namespace {

constexpr int kSamples = 2;  // a side of a pixel

/// Depth and colour of every sample.
class Raster {
 public:
  Raster(int width, int height)
      : width_(width),
        height_(height),
        depth_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
               -std::numeric_limits<double>::infinity()),
        colour_(depth_.size(), {255, 255, 255}) {}

  using Colour = std::array<std::uint8_t, 3>;

  /// A parallelogram p0, p1, p2, p3; samples within half a sample of its rim take the edge colour.
  void draw(const Isometric::Face& face, const Colour& fill, const Colour& edge) {
    const double ux = face[1].x - face[0].x, uy = face[1].y - face[0].y;
    const double vx = face[3].x - face[0].x, vy = face[3].y - face[0].y;
    const double det = ux * vy - uy * vx;
    if (std::abs(det) < 1e-9) return;
    const double width_u = std::abs(det) / std::max(1e-9, std::hypot(vx, vy));
    const double width_v = std::abs(det) / std::max(1e-9, std::hypot(ux, uy));
    double low_x = face[0].x, high_x = low_x, low_y = face[0].y, high_y = low_y;
    for (const Isometric::Point& p : face) {
      low_x = std::min(low_x, p.x);
      high_x = std::max(high_x, p.x);
      low_y = std::min(low_y, p.y);
      high_y = std::max(high_y, p.y);
    }
    for (int y = clamped(low_y - 0.5, height_); y < clamped(high_y + 0.5, height_); ++y) {
      for (int x = clamped(low_x - 0.5, width_); x < clamped(high_x + 0.5, width_); ++x) {
        const double px = x + 0.5 - face[0].x, py = y + 0.5 - face[0].y;
        const double u = (px * vy - py * vx) / det, v = (ux * py - uy * px) / det;
        if (u < 0 || u > 1 || v < 0 || v > 1) continue;
        const double depth = face[0].depth + u * (face[1].depth - face[0].depth) +
                             v * (face[3].depth - face[0].depth);
        const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                               static_cast<std::size_t>(x);
        if (depth <= depth_[at]) continue;
        depth_[at] = depth;
        const double rim = std::min(std::min(u, 1 - u) * width_u, std::min(v, 1 - v) * width_v);
        colour_[at] = rim < 1.0 ? edge : fill;
      }
    }
  }

  image::Image8 reduced() const {
    image::Image8 image{width_ / kSamples, height_ / kSamples, {}};
    image.rgba.reserve(colour_.size() / (kSamples * kSamples) * 4);
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        std::array<int, 3> sum{};
        for (int s = 0; s < kSamples * kSamples; ++s) {
          const auto row = static_cast<std::size_t>(y * kSamples + s / kSamples);
          const auto column = static_cast<std::size_t>(x * kSamples + s % kSamples);
          const Colour& c = colour_[row * static_cast<std::size_t>(width_) + column];
          for (std::size_t k = 0; k < 3; ++k) sum[k] += c[k];
        }
        for (const int channel : sum) {
          image.rgba.push_back(static_cast<std::uint8_t>(channel / (kSamples * kSamples)));
        }
        image.rgba.push_back(255);
      }
    }
    return image;
  }

 private:
  static int clamped(double value, int limit) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(limit)));
  }
  int width_, height_;
  std::vector<double> depth_;
  std::vector<Colour> colour_;
};

}  // namespace

image::Image8 level_picture(std::span<const Aabb> boxes, int width, int height) {
  width = std::clamp(width, 16, 8192);
  height = std::clamp(height, 16, 8192);
  const Isometric view(boxes, width * kSamples, height * kSamples);
  Raster raster(width * kSamples, height * kSamples);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    // Muted colours that tell neighbours apart, a function of the index alone.
    const std::uint64_t hash = mix_bits(i + 1);
    for (int axis = 0; axis < Isometric::kFaces; ++axis) {
      const double light = axis == 1 ? 1.0 : axis == 0 ? 0.82 : 0.64;
      Raster::Colour fill{}, edge{};
      for (std::size_t k = 0; k < 3; ++k) {
        const double tone = 150 + static_cast<double>((hash >> (8 * k)) & 0x5f);
        fill[k] = static_cast<std::uint8_t>(tone * light);
        edge[k] = static_cast<std::uint8_t>(tone * light * 0.35);
      }
      raster.draw(view.face(boxes[i], axis), fill, edge);
    }
  }
  return raster.reduced();
}

}  // namespace lightbatch::hierarchy
