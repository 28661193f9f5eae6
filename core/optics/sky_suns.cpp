// What hemisphere rays make of a picture: a part that brings the share f of all light, K times as
// bright as the mean, adds f K to the relative variance of one ray. The cap on pixels, a multiple
// of the mean of what is left, bounds that; what lies above it is cut by the widest direction, as
// in a median cut (Debevec 2005, A Median Cut Algorithm for Light Probe Sampling), but until the
// parts are narrow instead of equally strong, and each keeps its pixels: no shape is lost.

#include "core/optics/sky_suns.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>
#include <utility>

#include "core/optics/equirectangular.h"

namespace lightbatch::optics {
namespace {

/// Of the mean of what is left.
constexpr double kCap = 30;
/// Half the angle that a sun may take, rad: its light falls on a surface at about one cosine.
constexpr double kWidest = 0.1;
/// Every texel asks every one.
constexpr std::size_t kMostSuns = 16;
/// Relative variance of one hemisphere ray that is worth a light: that of a uniform sky behind a
/// half-open window.
constexpr double kWorth = 1;

double pixel_solid_angle(std::uint32_t row, int width, int height) {
  const auto top = static_cast<int>(row);
  return solid_angle(top, top + 1, 1, width, height);
}

double middle_height(std::uint32_t row, int height) {
  const auto top = static_cast<int>(row);
  return 0.5 * (border_height(top, height) + border_height(top + 1, height));
}

Vec3d pixel_direction(const SkySun::Pixel& p, int width, int height) {
  return direction_at((p.x + 0.5) / width, middle_height(p.y, height));
}

/// Pixels by brightness, 16 classes an octave (the leading bits of a float).
class Histogram {
 public:
  explicit Histogram(const image::ImageRgb& map) {
    for (int y = 0; y < map.height; ++y) {
      const double share =
          pixel_solid_angle(static_cast<std::uint32_t>(y), map.width, map.height) / (4 * kPiDouble);
      for (int x = 0; x < map.width; ++x) {
        const float value = map.at(x, y).sum();
        share_[class_of(value)] += share;
        light_[class_of(value)] += share * static_cast<double>(value);
      }
    }
  }
  /// The cap that is kCap times the mean of what it leaves; 0 where everything is above any.
  double cap() const {
    std::size_t at = kClasses - 1;
    for (;;) {
      const auto next = class_of(static_cast<float>(kCap * mean(at)));
      if (next >= at) return static_cast<double>(start_of(at));
      at = next;
    }
  }

 private:
  static constexpr int kShift = 19;
  static constexpr std::size_t kClasses = (0x7f800000u >> kShift) + 1;
  static std::size_t class_of(float value) {
    return std::min(std::bit_cast<std::uint32_t>(value) >> kShift,
                    static_cast<std::uint32_t>(kClasses - 1));
  }
  static float start_of(std::size_t at) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(at) << kShift);
  }
  /// Of the map with the values from a class on cut down to its start.
  double mean(std::size_t at) const {
    double sum = 0, above = 0;
    for (std::size_t i = 0; i < kClasses; ++i)
      (i < at ? sum : above) += i < at ? light_[i] : share_[i];
    return above > 0 ? sum + above * static_cast<double>(start_of(at)) : sum;
  }

  std::array<double, kClasses> share_{}, light_{};
};

/// What pixels have above the cap.
std::vector<SkySun::Pixel> above(const image::ImageRgb& map, double cap) {
  std::vector<SkySun::Pixel> bright;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const Rgb& p = map.at(x, y);
      const auto value = static_cast<double>(p.sum());
      if (!(value > cap)) continue;
      bright.push_back({static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                        p * static_cast<float>(1 - cap / value)});
    }
  }
  return bright;
}

/// Relative variance that they give one ray of uniform density, against the mean of the map.
double variance_of(std::span<const SkySun::Pixel> bright, const image::ImageRgb& map) {
  double mean = 0, square = 0;
  for (int y = 0; y < map.height; ++y) {
    double row = 0;
    for (int x = 0; x < map.width; ++x) row += static_cast<double>(map.at(x, y).sum());
    mean += row * pixel_solid_angle(static_cast<std::uint32_t>(y), map.width, map.height);
  }
  for (const SkySun::Pixel& p : bright) {
    const auto value = static_cast<double>(p.luminance.sum());
    square += value * value * pixel_solid_angle(p.y, map.width, map.height);
  }
  return mean > 0 ? square * 4 * kPiDouble / (mean * mean) : 0;
}

/// Cuts pixels into parts that are narrow; false: there would be too many.
bool cut_narrow(std::vector<SkySun::Pixel>& pixels, int width, int height,
                std::vector<std::pair<std::size_t, std::size_t>>& parts) {
  std::vector<std::pair<std::size_t, std::size_t>> stack{{0, pixels.size()}};
  while (!stack.empty()) {
    const auto [begin, end] = stack.back();
    stack.pop_back();
    const auto part = std::span(pixels).subspan(begin, end - begin);
    Vec3d mean, square;
    double weight = 0;
    for (const SkySun::Pixel& p : part) {
      const Vec3d d = pixel_direction(p, width, height);
      const double w =
          static_cast<double>(p.luminance.sum()) * pixel_solid_angle(p.y, width, height);
      mean = mean + d * w;
      square = square + Vec3d{d.x * d.x, d.y * d.y, d.z * d.z} * w;
      weight += w;
    }
    mean = mean / weight;
    const Vec3d axis = dot(mean, mean) > 0 ? normalized(mean) : Vec3d{0, 1, 0};
    const bool narrow = std::all_of(part.begin(), part.end(), [&](const SkySun::Pixel& p) {
      return dot(axis, pixel_direction(p, width, height)) > std::cos(kWidest);
    });
    if (narrow || part.size() == 1) {
      parts.emplace_back(begin, end);
    } else {
      const Vec3d spread =
          square / weight - Vec3d{mean.x * mean.x, mean.y * mean.y, mean.z * mean.z};
      const auto along = [&](const SkySun::Pixel& p) {
        const Vec3d d = pixel_direction(p, width, height);
        if (spread.x >= spread.y && spread.x >= spread.z) return d.x - mean.x;
        return spread.y >= spread.z ? d.y - mean.y : d.z - mean.z;
      };
      const auto middle = std::stable_partition(
          part.begin(), part.end(), [&](const SkySun::Pixel& p) { return along(p) < 0; });
      auto at = begin + static_cast<std::size_t>(middle - part.begin());
      if (at == begin || at == end) at = begin + part.size() / 2;  // rounded together
      stack.emplace_back(at, end);
      stack.emplace_back(begin, at);
    }
    if (parts.size() + stack.size() > kMostSuns) return false;
  }
  return true;
}

}  // namespace

SkySun::SkySun(int width, int height, std::vector<Pixel> pixels)
    : width_(width), height_(height), pixels_(std::move(pixels)) {
  std::vector<double> weights;
  weights.reserve(pixels_.size());
  Vec3d towards;
  std::array<Vec3d, 3> channel;
  for (const Pixel& p : pixels_) {
    const double solid_angle = pixel_solid_angle(p.y, width, height);
    const Vec3d d = pixel_direction(p, width, height) * solid_angle;
    const Rgbd luminance = to_double(p.luminance);
    weights.push_back(luminance.sum() * solid_angle);
    towards = towards + d * luminance.sum();
    channel[0] = channel[0] + d * luminance.r;
    channel[1] = channel[1] + d * luminance.g;
    channel[2] = channel[2] + d * luminance.b;
  }
  sampler_ = DiscreteSampler(weights);
  const Vec3d axis = normalized(towards);
  towards_ = to_float(axis);
  illuminance_ =
      to_float(Rgbd{dot(channel[0], axis), dot(channel[1], axis), dot(channel[2], axis)});
}

Vec3f SkySun::direction(Vec2f random) const {
  const DiscreteSampler::Pick pick = sampler_.pick(static_cast<double>(random.x));
  const Pixel& p = pixels_[pick.index];
  const auto row = static_cast<int>(p.y);
  const double top = border_height(row, height_), bottom = border_height(row + 1, height_);
  return to_float(direction_at((p.x + static_cast<double>(pick.rest)) / width_,
                               top + static_cast<double>(random.y) * (bottom - top)));
}

SplitSky split_suns(const Environment& sky) {
  SplitSky split{sky, {}};
  if (sky.is_uniform() || sky.is_black()) return split;
  const image::ImageRgb& map = *sky.map();
  double cap = Histogram(map).cap();
  std::vector<SkySun::Pixel> bright = above(map, cap);
  if (bright.empty() || variance_of(bright, map) < kWorth) return split;
  std::vector<std::pair<std::size_t, std::size_t>> parts;
  while (!bright.empty() && !cut_narrow(bright, map.width, map.height, parts)) {
    parts.clear();
    cap = cap > 0 ? 2 * cap : static_cast<double>(bright.front().luminance.sum());
    bright = above(map, cap);
  }
  if (bright.empty()) return split;
  for (const auto& [begin, end] : parts) {
    split.suns.emplace_back(
        map.width, map.height,
        std::vector<SkySun::Pixel>(bright.begin() + static_cast<std::ptrdiff_t>(begin),
                                   bright.begin() + static_cast<std::ptrdiff_t>(end)));
  }
  image::ImageRgb rest = map;
  for (const SkySun::Pixel& p : bright) {
    Rgb& pixel = rest.at(static_cast<int>(p.x), static_cast<int>(p.y));
    pixel *= static_cast<float>(cap / static_cast<double>(pixel.sum()));
  }
  split.rest = Environment(std::move(rest));
  return split;
}

}  // namespace lightbatch::optics
