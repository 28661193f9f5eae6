#include "core/optics/environment.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/optics/equirectangular.h"

namespace lightbatch::optics {
namespace {

constexpr int kMaxColumns = 1024;

float tame(float value, float scale) {
  const float v = value * scale;
  return std::isfinite(v) && v > 0 ? std::min(v, static_cast<float>(kMostRadiance)) : 0;
}

}  // namespace

Environment::Environment(const Rgb& radiance)
    : uniform_{tame(radiance.r, 1), tame(radiance.g, 1), tame(radiance.b, 1)},
      mean_(to_double(uniform_)) {}

Environment::Environment(image::ImageRgb map, float scale) {
  if (map.width <= 0 || map.height <= 0 || map.pixels.empty()) return;
  block_ = std::max(1, (map.width + kMaxColumns - 1) / kMaxColumns);
  columns_ = (map.width + block_ - 1) / block_;
  const int rows = (map.height + block_ - 1) / block_;
  std::vector<double> weights(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows));
  for (int y = 0; y < map.height; ++y) {
    const double share =
        (border_height(y, map.height) - border_height(y + 1, map.height)) / (2 * map.width);
    for (int x = 0; x < map.width; ++x) {
      Rgb& p = map.at(x, y);
      p = {tame(p.r, scale), tame(p.g, scale), tame(p.b, scale)};
      mean_ += to_double(p) * share;
      weights[static_cast<std::size_t>(y / block_) * static_cast<std::size_t>(columns_) +
              static_cast<std::size_t>(x / block_)] += to_double(p).sum() * share;
    }
  }
  sampler_ = DiscreteSampler(weights);
  map_ = std::make_shared<const image::ImageRgb>(std::move(map));
}

Environment::Pixel Environment::pixel(const Vec3f& direction) const {
  const Vec3d d = to_double(direction);
  const double u = std::atan2(d.z, d.x) / (2 * kPiDouble) + 0.5;
  const double v = std::acos(std::clamp(d.y, -1.0, 1.0)) / kPiDouble;
  return {std::clamp(static_cast<int>(u * map_->width), 0, map_->width - 1),
          std::clamp(static_cast<int>(v * map_->height), 0, map_->height - 1)};
}

Rgb Environment::radiance(const Vec3f& direction) const {
  if (is_uniform()) return uniform_;
  const Pixel p = pixel(direction);
  return map_->at(p.x, p.y);
}

double Environment::solid_angle(int block_row, int block_column) const {
  const int top = block_row * block_, bottom = std::min(top + block_, map_->height);
  const int left = block_column * block_, right = std::min(left + block_, map_->width);
  return optics::solid_angle(top, bottom, right - left, map_->width, map_->height);
}

Environment::Sample Environment::sample(double random_a, double random_b) const {
  Sample s;
  double u = random_a, y = 1 - 2 * random_b;
  if (!is_uniform()) {
    const DiscreteSampler::Pick pick = sampler_.pick(random_a);
    const int row = static_cast<int>(pick.index) / columns_;
    const int column = static_cast<int>(pick.index) % columns_;
    const int left = column * block_, right = std::min(left + block_, map_->width);
    u = (left + pick.rest * (right - left)) / map_->width;
    const double top = border_height(row * block_, map_->height);
    const double bottom = border_height(std::min((row + 1) * block_, map_->height), map_->height);
    y = top + random_b * (bottom - top);
  }
  s.direction = to_float(direction_at(u, y));
  s.radiance = radiance(s.direction);
  s.density = density(s.direction);
  if (!(s.density > 0)) {  // rounded into a black block beside the picked one
    s.radiance = {};
    s.density = 1 / (4 * kPiDouble);
  }
  return s;
}

double Environment::density(const Vec3f& direction) const {
  if (is_uniform()) return 1 / (4 * kPiDouble);
  const Pixel p = pixel(direction);
  const int row = p.y / block_, column = p.x / block_;
  const auto index = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                     static_cast<std::size_t>(column);
  return sampler_.probability(index) / solid_angle(row, column);
}

}  // namespace lightbatch::optics
