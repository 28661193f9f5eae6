#include "core/radiosity/spherical_triangle.h"

#include <algorithm>
#include <cmath>

namespace lightbatch::radiosity {
namespace {

Vec3d unit(const Vec3d& v) {
  const double size = length(v);
  return size > 0 ? v / size : Vec3d{};
}

double root(double v) { return std::sqrt(std::max(0.0, v)); }

}  // namespace

SphericalTriangle::SphericalTriangle(const Vec3d& point, const std::array<Vec3f, 3>& corners) {
  for (std::size_t i = 0; i < 3; ++i) towards_[i] = unit(to_double(corners[i]) - point);
  const auto& [a, b, c] = towards_;
  // Van Oosterom and Strackee 1983: stable for small and for large triangles.
  const double volume = std::fabs(dot(a, cross(b, c)));
  const double area = 2 * std::atan2(volume, 1 + dot(a, b) + dot(b, c) + dot(c, a));
  const Vec3d ab = unit(cross(a, b)), ca = unit(cross(c, a));
  alpha_ = std::acos(std::clamp(-dot(ab, ca), -1.0, 1.0));
  cos_ab_ = dot(a, b);
  if (volume > 0 && alpha_ > 0 && std::isfinite(area)) solid_angle_ = area;
}

Vec3d SphericalTriangle::direction(double a, double b) const {
  const double part = a * solid_angle_ - alpha_;
  const double s = std::sin(part), t = std::cos(part);
  const double cos_alpha = std::cos(alpha_), sin_alpha = std::sin(alpha_);
  const double u = t - cos_alpha;
  const double v = s + sin_alpha * cos_ab_;
  const double below = (v * s + u * t) * sin_alpha;
  const double q =
      below != 0 ? std::clamp(((v * t - u * s) * cos_alpha - v) / below, -1.0, 1.0) : 1.0;
  const auto& [first, second, third] = towards_;
  const Vec3d c = first * q + unit(third - first * dot(third, first)) * root(1 - q * q);
  const double z = 1 - b * (1 - dot(c, second));
  return second * z + unit(c - second * dot(c, second)) * root(1 - z * z);
}

}  // namespace lightbatch::radiosity
