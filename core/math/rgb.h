#pragma once

#include <algorithm>
#include <cmath>

namespace lightbatch {

/// Three linear Rec. 709 channels of any light quantity or reflectance.
template <typename T>
struct BasicRgb {
  T r{}, g{}, b{};

  static constexpr BasicRgb grey(T value) { return {value, value, value}; }

  constexpr BasicRgb operator+(const BasicRgb& o) const { return {r + o.r, g + o.g, b + o.b}; }
  constexpr BasicRgb operator-(const BasicRgb& o) const { return {r - o.r, g - o.g, b - o.b}; }
  constexpr BasicRgb operator*(const BasicRgb& o) const { return {r * o.r, g * o.g, b * o.b}; }
  constexpr BasicRgb operator*(T s) const { return {r * s, g * s, b * s}; }
  constexpr BasicRgb operator/(T s) const { return {r / s, g / s, b / s}; }
  constexpr BasicRgb& operator+=(const BasicRgb& o) { return *this = *this + o; }
  constexpr BasicRgb& operator-=(const BasicRgb& o) { return *this = *this - o; }
  constexpr BasicRgb& operator*=(const BasicRgb& o) { return *this = *this * o; }
  constexpr BasicRgb& operator*=(T s) { return *this = *this * s; }
  constexpr bool operator==(const BasicRgb&) const = default;

  constexpr T max() const { return std::max(r, std::max(g, b)); }
  constexpr T sum() const { return r + g + b; }
  constexpr bool is_black() const { return r == T(0) && g == T(0) && b == T(0); }
};

/// Storage.
using Rgb = BasicRgb<float>;
/// Sums.
using Rgbd = BasicRgb<double>;

constexpr Rgbd to_double(const Rgb& c) {
  return {static_cast<double>(c.r), static_cast<double>(c.g), static_cast<double>(c.b)};
}
constexpr Rgb to_float(const Rgbd& c) {
  return {static_cast<float>(c.r), static_cast<float>(c.g), static_cast<float>(c.b)};
}
template <typename T>
bool is_finite(const BasicRgb<T>& c) {
  return std::isfinite(c.r) && std::isfinite(c.g) && std::isfinite(c.b);
}
/// Rec. 709 luminance weights.
template <typename T>
constexpr T luminance(const BasicRgb<T>& c) {
  return T(0.2126) * c.r + T(0.7152) * c.g + T(0.0722) * c.b;
}

/// IEC 61966-2-1 transfer functions, both on [0, 1].
inline float srgb_to_linear(float v) {
  return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}
inline float linear_to_srgb(float v) {
  return v <= 0.0031308f ? v * 12.92f : 1.055f * std::pow(v, 1.0f / 2.4f) - 0.055f;
}

}  // namespace lightbatch
