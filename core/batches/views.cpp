#include "core/batches/views.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lightbatch::batches {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kPitch = 20 * kPi / 180;  // people look this far up and down
constexpr double kFacesUp = 0.7;           // cosine: floors, stairs and ramps

/// van der Corput radical inverse.
double radical_inverse(std::uint32_t base, std::uint32_t index) {
  double result = 0, scale = 1.0 / base;
  for (; index > 0; index /= base, scale /= base) result += (index % base) * scale;
  return result;
}

Vec3d direction(double yaw, double pitch) {
  return {std::sin(yaw) * std::cos(pitch), std::sin(pitch), std::cos(yaw) * std::cos(pitch)};
}

/// Eyes on a sphere around the scene, above the horizon, at a distance that holds all of it.
Vec3d outside_eye(const Aabb& box, std::uint32_t index) {
  const double radius = 0.5 * static_cast<double>(box.diagonal());
  const double yaw = 2 * kPi * radical_inverse(2, index);
  const double pitch = std::asin(0.1 + 0.6 * radical_inverse(3, index));
  return to_double(box.centre()) +
         direction(yaw, pitch) * (radius * (1.2 + 0.8 * radical_inverse(5, index)));
}

double eye_height(const Aabb& box, const Profile& profile) {
  const double diagonal = static_cast<double>(box.diagonal());
  const double height = static_cast<double>(box.extent().y);
  return std::min({profile.eye_height > 0 ? std::max(profile.eye_height, 0.02 * diagonal) : 0.0,
                   0.5 * height, 0.1 * diagonal});
}

/// Share of the directions centre +- spread whose field of +- half meets [low, high].
double overlap_share(double low, double high, double centre, double spread, double half) {
  if (!(spread > 0)) return low - half <= centre && centre <= high + half ? 1 : 0;
  const double from = std::max(low - half, centre - spread);
  const double to = std::min(high + half, centre + spread);
  return std::clamp((to - from) / (2 * spread), 0.0, 1.0);
}

double wrap(double angle) { return std::remainder(angle, 2 * kPi); }

}  // namespace

std::vector<Vec3d> standing_eyes(const scene::Scene& scene, const Profile& profile,
                                 std::uint32_t count, std::uint32_t skip) {
  std::vector<double> sum;  // running area of triangles that face up
  std::vector<std::uint32_t> index;
  double total = 0;
  for (std::uint32_t i = 0; i < scene.triangles.size(); ++i) {
    const auto c = scene.corners(i);
    const Vec3d n = cross(to_double(c[1]) - to_double(c[0]), to_double(c[2]) - to_double(c[0]));
    const double twice = length(n);
    if (!(n.y > kFacesUp * twice) || !(twice > 0)) continue;
    total += twice;
    sum.push_back(total);
    index.push_back(i);
  }
  std::vector<Vec3d> eyes;
  if (!(total > 0)) return eyes;
  const double height = eye_height(scene.box, profile);
  const double ceiling = static_cast<double>(scene.box.upper.y);
  for (std::uint32_t k = 0; k < count; ++k) {
    const std::uint32_t at = skip + k + 1;
    const double target = radical_inverse(2, at) * total;
    auto it = std::upper_bound(sum.begin(), sum.end(), target);
    if (it == sum.end()) --it;
    const auto c = scene.corners(index[static_cast<std::size_t>(it - sum.begin())]);
    const double root = std::sqrt(radical_inverse(3, at));
    const double v = radical_inverse(5, at) * root;
    Vec3d p = to_double(c[0]) * (1 - root) + to_double(c[1]) * (root - v) + to_double(c[2]) * v;
    p.y = std::min(p.y + height, std::max(p.y, ceiling - 0.1 * height));
    eyes.push_back(p);
  }
  return eyes;
}

std::vector<View> sampled_views(const scene::Scene& scene, const Profile& profile,
                                std::uint32_t inside, std::uint32_t outside, std::uint32_t start) {
  std::vector<View> views;
  if (scene.box.is_empty()) return views;
  const auto eyes = standing_eyes(scene, profile, inside, start);
  for (std::uint32_t k = 0; k < eyes.size(); ++k) {
    const std::uint32_t at = start + k;
    views.push_back({eyes[k], 2 * kPi * radical_inverse(7, at),
                     kPitch * (radical_inverse(11, at) - 0.5), true});
  }
  for (std::uint32_t k = 0; k < outside; ++k) {
    const Vec3d eye = outside_eye(scene.box, start + k);
    const Vec3d to = to_double(scene.box.centre()) - eye;
    views.push_back({eye, std::atan2(to.x, to.z), std::atan2(to.y, std::hypot(to.x, to.z)), false});
  }
  return views;
}

ViewDistribution::ViewDistribution(const scene::Scene& scene, const Profile& profile) {
  half_pitch_ = 0.5 * profile.field_of_view * kPi / 180;
  half_yaw_ = std::atan(std::tan(half_pitch_) * profile.aspect);
  // The planes above and below a view meet lower elevations at its sides than in its middle: by the
  // cosine of the yaw between, here its mean.
  flattening_ = std::sin(half_yaw_) / half_yaw_;
  if (scene.box.is_empty()) return;
  const auto standing = standing_eyes(scene, profile, kInsideEyes, 0);
  const double inside = standing.empty() ? 0 : profile.inside;
  for (const Vec3d& p : standing)
    eyes_.push_back({p, inside / static_cast<double>(standing.size()), 0, kPi, 0, kPitch, true});
  inside_weight_ = inside;
  const double radius = 0.5 * static_cast<double>(scene.box.diagonal());
  for (std::uint32_t k = 0; k < kOutsideEyes; ++k) {
    Eye eye;
    eye.position = outside_eye(scene.box, k + 1);
    eye.weight = (1 - inside) / kOutsideEyes;
    const Vec3d to = to_double(scene.box.centre()) - eye.position;
    const double distance = length(to);
    eye.yaw = std::atan2(to.x, to.z);
    eye.pitch = std::atan2(to.y, std::hypot(to.x, to.z));
    eye.yaw_spread = eye.pitch_spread =
        distance > 0 ? 0.5 * std::asin(std::min(1.0, radius / distance)) : 0;
    eyes_.push_back(eye);
  }
}

Chance ViewDistribution::chance(const Aabb& box) const {
  if (box.is_empty()) return {};
  const Vec3d lower = to_double(box.lower), upper = to_double(box.upper);
  double from_inside = 0, from_outside = 0;
  for (const Eye& eye : eyes_) {
    // The footprint's interval of yaw, from its centre's: at most a half turn wide when the eye is
    // not above it.
    const double x0 = lower.x - eye.position.x, x1 = upper.x - eye.position.x;
    const double z0 = lower.z - eye.position.z, z1 = upper.z - eye.position.z;
    const bool above = x0 <= 0 && x1 >= 0 && z0 <= 0 && z1 >= 0;
    double horizontal = 1;
    const double near_x = std::max({x0, -x1, 0.0}), near_z = std::max({z0, -z1, 0.0});
    const double nearest = std::hypot(near_x, near_z);
    if (!above) {
      // Angles from the centre's direction: by their tangents while all are below a right angle.
      const double cx = 0.5 * (x0 + x1), cz = 0.5 * (z0 + z1);
      double low = 0, high = 0, least = 1;
      for (const auto& [x, z] : {std::pair{x0, z0}, {x0, z1}, {x1, z0}, {x1, z1}}) {
        const double across = x * cz - z * cx, along = x * cx + z * cz;
        least = std::min(least, along);
        if (!(along > 0)) continue;
        low = std::min(low, across / along);
        high = std::max(high, across / along);
      }
      if (least > 0) {
        low = std::atan(low);
        high = std::atan(high);
      } else {
        low = high = 0;
        for (const auto& [x, z] : {std::pair{x0, z0}, {x0, z1}, {x1, z0}, {x1, z1}}) {
          const double angle = std::atan2(x * cz - z * cx, x * cx + z * cz);
          low = std::min(low, angle);
          high = std::max(high, angle);
        }
      }
      if (eye.yaw_spread >= kPi) {
        horizontal = std::min(1.0, (high - low + 2 * half_yaw_) / (2 * kPi));
      } else {
        const double offset = wrap(std::atan2(cx, cz) - eye.yaw);
        horizontal = overlap_share(offset + low, offset + high, 0, eye.yaw_spread, half_yaw_);
      }
    }
    if (horizontal <= 0) continue;
    const double farthest = std::hypot(std::max(-x0, x1), std::max(-z0, z1));
    const double y0 = lower.y - eye.position.y, y1 = upper.y - eye.position.y;
    const double low = std::atan2(y0, flattening_ * (y0 < 0 ? nearest : farthest));
    const double high = std::atan2(y1, flattening_ * (y1 > 0 ? nearest : farthest));
    (eye.inside ? from_inside : from_outside) +=
        eye.weight * horizontal *
        overlap_share(low, high, eye.pitch, eye.pitch_spread, half_pitch_);
  }
  Chance result;
  result.any = std::min(from_inside + from_outside, 1.0);
  result.inside = inside_weight_ > 0 ? std::min(from_inside / inside_weight_, 1.0) : result.any;
  return result;
}

Frustum::Frustum(const View& view, const Profile& profile) {
  const double half_pitch = 0.5 * profile.field_of_view * kPi / 180;
  const double half_yaw = std::atan(std::tan(half_pitch) * profile.aspect);
  const Vec3d forward = direction(view.yaw, view.pitch);
  const Vec3d right{std::cos(view.yaw), 0, -std::sin(view.yaw)};
  const Vec3d up = cross(forward, right);
  const Vec3d normals[5] = {forward, forward * std::sin(half_yaw) + right * std::cos(half_yaw),
                            forward * std::sin(half_yaw) - right * std::cos(half_yaw),
                            forward * std::sin(half_pitch) + up * std::cos(half_pitch),
                            forward * std::sin(half_pitch) - up * std::cos(half_pitch)};
  for (int i = 0; i < 5; ++i) planes_[i] = {normals[i], dot(normals[i], view.eye)};
}

bool Frustum::outside(const Aabb& box) const {
  for (const Plane& p : planes_) {
    const Vec3d farthest{static_cast<double>(p.normal.x > 0 ? box.upper.x : box.lower.x),
                         static_cast<double>(p.normal.y > 0 ? box.upper.y : box.lower.y),
                         static_cast<double>(p.normal.z > 0 ? box.upper.z : box.lower.z)};
    if (dot(p.normal, farthest) < p.offset) return true;
  }
  return box.is_empty();
}

bool Frustum::holds(const Aabb& box) const {
  for (const Plane& p : planes_) {
    const Vec3d nearest{static_cast<double>(p.normal.x > 0 ? box.lower.x : box.upper.x),
                        static_cast<double>(p.normal.y > 0 ? box.lower.y : box.upper.y),
                        static_cast<double>(p.normal.z > 0 ? box.lower.z : box.upper.z)};
    if (dot(p.normal, nearest) < p.offset) return false;
  }
  return !box.is_empty();
}

bool Frustum::outside(const Vec3d& a, const Vec3d& b, const Vec3d& c) const {
  for (const Plane& p : planes_)
    if (dot(p.normal, a) < p.offset && dot(p.normal, b) < p.offset && dot(p.normal, c) < p.offset)
      return true;
  return false;
}

}  // namespace lightbatch::batches
