#include "core/batches/views.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lightbatch::batches {
namespace {

constexpr double kPi = std::numbers::pi;
/// Share of the directions centre +- spread whose field of +- half meets [low, high].
double overlap_share(double low, double high, double centre, double spread, double half) {
  if (!(spread > 0)) return low - half <= centre && centre <= high + half ? 1 : 0;
  const double from = std::max(low - half, centre - spread);
  const double to = std::min(high + half, centre + spread);
  return std::clamp((to - from) / (2 * spread), 0.0, 1.0);
}

/// atan2 within 2e-8 rad: minimax polynomial of Abramowitz and Stegun 1964, 4.4.49. Chances are
/// asked for millions of times and are estimates by far.
double quick_atan2(double y, double x) {
  const double ax = std::abs(x), ay = std::abs(y);
  const double larger = std::max(ax, ay);
  if (!(larger > 0)) return 0;
  const double t = std::min(ax, ay) / larger, s = t * t;
  double angle =
      t *
      (1 +
       s * (-0.3333314528 +
            s * (0.1999355085 +
                 s * (-0.1420889944 +
                      s * (0.1065626393 +
                           s * (-0.0752896400 +
                                s * (0.0429096138 + s * (-0.0161657367 + s * 0.0028662257))))))));
  if (ay > ax) angle = 0.5 * kPi - angle;
  if (x < 0) angle = kPi - angle;
  return std::copysign(angle, y);
}

/// Distances are of a scene's size: no care for overflow is needed.
double flat_length(double x, double z) { return std::sqrt(x * x + z * z); }

double wrap(double angle) { return std::remainder(angle, 2 * kPi); }

}  // namespace

ViewDistribution::ViewDistribution(const Viewpoints& viewpoints) {
  const Profile& profile = viewpoints.profile();
  const Aabb& box = viewpoints.box();
  half_pitch_ = 0.5 * profile.field_of_view * kPi / 180;
  half_yaw_ = std::atan(std::tan(half_pitch_) * profile.aspect);
  // The planes above and below a view meet lower elevations at its sides than in its middle: by the
  // cosine of the yaw between, here its mean.
  flattening_ = std::sin(half_yaw_) / half_yaw_;
  if (box.is_empty()) return;
  if (!viewpoints.cameras().empty()) {
    add_cameras(viewpoints.cameras());
    return;
  }
  const auto standing = viewpoints.standing_eyes(kInsideEyes, 0);
  const double inside = standing.empty() ? 0 : profile.inside;
  for (const Vec3d& p : standing)
    eyes_.push_back({p, inside / static_cast<double>(standing.size()), 0, kPi, 0, kPitch, true});
  inside_weight_ = inside;
  const double radius = 0.5 * static_cast<double>(box.diagonal());
  for (std::uint32_t k = 0; k < kOutsideEyes; ++k) {
    Eye eye;
    eye.position = viewpoints.outside_eye(k + 1);
    eye.weight = (1 - inside) / kOutsideEyes;
    const Vec3d to = to_double(box.centre()) - eye.position;
    const double distance = length(to);
    eye.yaw = std::atan2(to.x, to.z);
    eye.pitch = std::atan2(to.y, std::hypot(to.x, to.z));
    eye.yaw_spread = eye.pitch_spread =
        distance > 0 ? 0.5 * std::asin(std::min(1.0, radius / distance)) : 0;
    eyes_.push_back(eye);
  }
}

void ViewDistribution::add_cameras(const std::vector<View>& cameras) {
  double total = 0;
  for (const View& view : cameras) total += view.weight;
  const std::size_t count = std::min(cameras.size(), kCameraEyes);
  const bool all = count == cameras.size();
  double sum = 0;
  std::size_t next = 0;
  for (const View& view : cameras) {
    sum += view.weight;
    // Systematic draws: the middles of equal steps through the weights.
    double weight = all ? view.weight / total : 0;
    for (; !all && next < count &&
           (static_cast<double>(next) + 0.5) * total <= sum * static_cast<double>(count);
         ++next)
      weight += 1 / static_cast<double>(count);
    if (weight > 0) eyes_.push_back({view.eye, weight, view.yaw, 0, view.pitch, 0, true});
  }
  inside_weight_ = 1;
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
    const double nearest = flat_length(near_x, near_z);
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
        low = quick_atan2(low, 1);
        high = quick_atan2(high, 1);
      } else {
        low = high = 0;
        for (const auto& [x, z] : {std::pair{x0, z0}, {x0, z1}, {x1, z0}, {x1, z1}}) {
          const double angle = quick_atan2(x * cz - z * cx, x * cx + z * cz);
          low = std::min(low, angle);
          high = std::max(high, angle);
        }
      }
      if (eye.yaw_spread >= kPi) {
        horizontal = std::min(1.0, (high - low + 2 * half_yaw_) / (2 * kPi));
      } else {
        const double offset = wrap(quick_atan2(cx, cz) - eye.yaw);
        horizontal = overlap_share(offset + low, offset + high, 0, eye.yaw_spread, half_yaw_);
      }
    }
    if (horizontal <= 0) continue;
    const double farthest = flat_length(std::max(-x0, x1), std::max(-z0, z1));
    const double y0 = lower.y - eye.position.y, y1 = upper.y - eye.position.y;
    const double low = quick_atan2(y0, flattening_ * (y0 < 0 ? nearest : farthest));
    const double high = quick_atan2(y1, flattening_ * (y1 > 0 ? nearest : farthest));
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

bool Frustum::outside(const Aabb& box, std::uint32_t& planes) const {
  if (box.is_empty()) return true;
  const Vec3d lower = to_double(box.lower), upper = to_double(box.upper);
  for (std::uint32_t i = 0; i < 5; ++i) {
    if ((planes >> i & 1) == 0) continue;
    const Vec3d& n = planes_[i].normal;
    const Vec3d farthest{n.x > 0 ? upper.x : lower.x, n.y > 0 ? upper.y : lower.y,
                         n.z > 0 ? upper.z : lower.z};
    if (dot(n, farthest) < planes_[i].offset) return true;
    const Vec3d nearest = lower + upper - farthest;
    if (dot(n, nearest) >= planes_[i].offset) planes &= ~(1u << i);
  }
  return false;
}

bool Frustum::outside(const Vec3d& a, const Vec3d& b, const Vec3d& c) const {
  for (const Plane& p : planes_)
    if (dot(p.normal, a) < p.offset && dot(p.normal, b) < p.offset && dot(p.normal, c) < p.offset)
      return true;
  return false;
}

}  // namespace lightbatch::batches
