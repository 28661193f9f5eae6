#include "core/batches/viewpoints.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lightbatch::batches {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kFacesUp = 0.7;  // cosine: floors, stairs and ramps

/// van der Corput radical inverse.
double radical_inverse(std::uint32_t base, std::uint32_t index) {
  double result = 0, scale = 1.0 / base;
  for (; index > 0; index /= base, scale /= base) result += (index % base) * scale;
  return result;
}

}  // namespace

Vec3d direction(double yaw, double pitch) {
  return {std::sin(yaw) * std::cos(pitch), std::sin(pitch), std::cos(yaw) * std::cos(pitch)};
}

Viewpoints::Viewpoints(const scene::Scene& scene, const Profile& profile, std::vector<View> cameras)
    : scene_(scene), profile_(profile), cameras_(std::move(cameras)), box_(scene.box) {
  double total = 0;
  for (std::uint32_t i = 0; i < scene.triangles.size(); ++i) {
    const auto c = scene.corners(i);
    const Vec3d n = cross(to_double(c[1]) - to_double(c[0]), to_double(c[2]) - to_double(c[0]));
    if (!(n.y > 0)) continue;
    const double twice = length(n);
    if (!(n.y > kFacesUp * twice)) continue;
    total += twice;
    area_.push_back(total);
    triangle_.push_back(i);
  }
}

std::vector<Vec3d> Viewpoints::standing_eyes(std::uint32_t count, std::uint32_t skip) const {
  std::vector<Vec3d> eyes;
  if (area_.empty()) return eyes;
  const double height = eye_height();
  const double ceiling = static_cast<double>(box_.upper.y);
  for (std::uint32_t k = 0; k < count; ++k) {
    const std::uint32_t at = skip + k + 1;
    const double target = radical_inverse(2, at) * area_.back();
    auto it = std::upper_bound(area_.begin(), area_.end(), target);
    if (it == area_.end()) --it;
    const auto c = scene_.corners(triangle_[static_cast<std::size_t>(it - area_.begin())]);
    const double root = std::sqrt(radical_inverse(3, at));
    const double v = radical_inverse(5, at) * root;
    Vec3d p = to_double(c[0]) * (1 - root) + to_double(c[1]) * (root - v) + to_double(c[2]) * v;
    p.y = std::min(p.y + height, std::max(p.y, ceiling - 0.1 * height));
    eyes.push_back(p);
  }
  return eyes;
}

double Viewpoints::eye_height() const {
  const double diagonal = static_cast<double>(box_.diagonal());
  const double height = static_cast<double>(box_.extent().y);
  return std::min({profile_.eye_height > 0 ? std::max(profile_.eye_height, 0.02 * diagonal) : 0.0,
                   0.5 * height, 0.1 * diagonal});
}

Vec3d Viewpoints::outside_eye(std::uint32_t index) const {
  const double radius = 0.5 * static_cast<double>(box_.diagonal());
  const double yaw = 2 * kPi * radical_inverse(2, index);
  const double pitch = std::asin(0.1 + 0.6 * radical_inverse(3, index));
  return to_double(box_.centre()) +
         direction(yaw, pitch) * (radius * (1.2 + 0.8 * radical_inverse(5, index)));
}

std::vector<View> Viewpoints::sample(std::uint32_t inside, std::uint32_t outside,
                                     std::uint32_t start) const {
  if (!cameras_.empty() || box_.is_empty()) return cameras_;
  std::vector<View> views;
  const auto eyes = standing_eyes(inside, start);
  for (std::uint32_t k = 0; k < eyes.size(); ++k) {
    const std::uint32_t at = start + k;
    views.push_back({eyes[k], 2 * kPi * radical_inverse(7, at),
                     kPitch * (radical_inverse(11, at) - 0.5), true});
  }
  for (std::uint32_t k = 0; k < outside; ++k) {
    const Vec3d eye = outside_eye(start + k);
    const Vec3d to = to_double(box_.centre()) - eye;
    views.push_back({eye, std::atan2(to.x, to.z), std::atan2(to.y, std::hypot(to.x, to.z)), false});
  }
  return views;
}

}  // namespace lightbatch::batches
