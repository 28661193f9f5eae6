#include "core/lightmap/shared_blocks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/lightmap/block_curve.h"
#include "core/lightmap/neighbours.h"

namespace lightbatch::lightmap {
namespace {

/// Standard errors that a block's middle may be off by for noise.
constexpr float kDeviations = 0.8f;
/// What noise does not excuse: more than so many tolerances and this share of a block's light.
constexpr double kLargeStep = 8;
constexpr float kMostExcused = 0.5f;
/// Corners whose normals differ more than this (cosine) do not share.
constexpr float kSameSurface = 0.97f;

}  // namespace

SharedBlocks::Place SharedBlocks::place(const Block& b, int x, int y) const {
  return {x, y, texel_at(input_.texels, input_.layout, b.chart, x, y)};
}

std::array<std::uint32_t, 4> SharedBlocks::corners(const Block& b) const {
  return {place(b, b.x0, b.y0).texel, place(b, b.x1, b.y0).texel, place(b, b.x0, b.y1).texel,
          place(b, b.x1, b.y1).texel};
}

SharedBlocks::Place SharedBlocks::middle(const Block& b) const {
  const Place first = place(b, (b.x0 + b.x1) / 2, (b.y0 + b.y1) / 2);
  for (const Place& m : {first, place(b, (b.x0 + b.x1 + 1) / 2, (b.y0 + b.y1 + 1) / 2)}) {
    if (m.texel != scene::kNone && !map_.is_shared(m.texel)) return m;
  }
  return first;
}

SharedBlocks::Place SharedBlocks::opposite(const Block& b, const Place& middle) const {
  return place(b, b.x1 - b.x0 == 1 ? b.x0 + b.x1 - middle.x : middle.x,
               b.y1 - b.y0 == 1 ? b.y0 + b.y1 - middle.y : middle.y);
}

bool SharedBlocks::is_predicted(const Block& b) const {
  const std::array<std::uint32_t, 4> corner = corners(b);
  float nearest = std::numeric_limits<float>::infinity();
  for (const std::uint32_t c : corner) {
    if (c == scene::kNone) return false;
    nearest = std::min(nearest, map_.texel[c].distance);
    if (dot(map_.texel[c].normal, map_.texel[corner[0]].normal) < kSameSurface) return false;
  }
  const bool covered = map_.texel[corner[0]].covered;
  for (int y = b.y0; y <= b.y1; ++y) {
    for (int x = b.x0; x <= b.x1; ++x) {
      const std::uint32_t t = place(b, x, y).texel;
      if (t == scene::kNone || map_.texel[t].covered != covered) return false;
    }
  }
  const double edge = std::max(b.x1 - b.x0, b.y1 - b.y0) / input_.layout.texels_per_metre;
  // Under what is nearer than a texel nothing finer is to be seen.
  if (!covered && edge > settings_.reach * static_cast<double>(nearest)) return false;
  const Place m = middle(b);
  return follows(b, corner, m) && (!is_strip(b) || follows(b, corner, opposite(b, m)));
}

bool SharedBlocks::follows(const Block& b, const std::array<std::uint32_t, 4>& corner,
                           const Place& at) const {
  // In a larger block: it tells nothing.
  if (map_.is_shared(at.texel)) return true;
  const MiddleOff off = middle_off(map_.texel, corner, at.texel, corner_shares(b, at.x, at.y));
  const float worst = std::max({std::fabs(off.lux.r), std::fabs(off.lux.g), std::fabs(off.lux.b)});
  const double tolerance = settings_.tolerance * dim_.at(at.texel) * input_.mean_irradiance;
  if (static_cast<double>(worst) <= tolerance) return true;
  // Noise alone makes as much: finer texels would be as noisy. But not a step: where few rays
  // find the light, as at the mouth of a crack, variance explains everything.
  const Rgb& light = map_.texel[at.texel].irradiance;
  const Rgb guess = light - off.lux;
  const bool step = static_cast<double>(worst) > kLargeStep * tolerance &&
                    worst > kMostExcused * std::max(guess.max(), light.max());
  return !step && worst * worst <= kDeviations * kDeviations * off.variance;
}

void SharedBlocks::fill(const Block& b) {
  const std::array<std::uint32_t, 4> corner = corners(b);
  auto& texel = map_.texel;
  auto& by_group = map_.by_group;
  float nearest = std::numeric_limits<float>::infinity();
  for (const std::uint32_t c : corner) nearest = std::min(nearest, texel[c].distance);
  const Place m = middle(b);
  const std::array<float, 4> at_middle = corner_shares(b, m.x, m.y);
  // A middle that is shared itself, in a larger block, tells nothing.
  const MiddleOff off =
      map_.is_computed(m.texel) ? middle_off(texel, corner, m.texel, at_middle) : MiddleOff{};
  BlockCurve curve(off, at_middle);
  curve.keep_positive(corner, m.texel, [&](std::uint32_t t) { return texel[t].irradiance; });
  for (std::size_t g = 0; g < by_group.groups(); ++g) {
    curve.keep_positive(corner, m.texel, [&](std::uint32_t t) { return by_group.of(t)[g]; });
  }
  for (int y = b.y0; y <= b.y1; ++y) {
    for (int x = b.x0; x <= b.x1; ++x) {
      const std::uint32_t t = place(b, x, y).texel;
      if (map_.state[t] != TexelState::kUnknown && !map_.is_shared(t)) continue;
      // A corner may be shared itself, in a larger block.
      if (std::find(corner.begin(), corner.end(), t) != corner.end()) continue;
      std::array<float, 4> share = corner_shares(b, x, y);
      const float of_middle = curve.of_middle(share);
      texel[t].irradiance = texel[m.texel].irradiance * of_middle;
      texel[t].normal = texel[corner[0]].normal;
      texel[t].distance = nearest;
      for (std::size_t g = 0; g < by_group.groups(); ++g) {
        by_group.of(t)[g] = by_group.of(m.texel)[g] * of_middle;
      }
      for (std::size_t i = 0; i < 4; ++i) {
        texel[t].irradiance += texel[corner[i]].irradiance * share[i];
        for (std::size_t g = 0; g < by_group.groups(); ++g) {
          by_group.of(t)[g] += by_group.of(corner[i])[g] * share[i];
        }
      }
      map_.state[t] = TexelState::kShared;
    }
  }
}

void SharedBlocks::clear(const Block& b) {
  for (int y = b.y0; y <= b.y1; ++y) {
    for (int x = b.x0; x <= b.x1; ++x) {
      const std::uint32_t t = place(b, x, y).texel;
      if (map_.is_shared(t)) map_.state[t] = TexelState::kUnknown;
    }
  }
}

void SharedBlocks::cut(const Block& b, std::vector<Block>& next) {
  if (b.x1 - b.x0 <= 1 && b.y1 - b.y0 <= 1) return;
  const int xm = (b.x0 + b.x1) / 2;
  const int ym = (b.y0 + b.y1) / 2;
  const std::array<std::array<int, 2>, 2> xs{{{b.x0, xm}, {xm, b.x1}}};
  const std::array<std::array<int, 2>, 2> ys{{{b.y0, ym}, {ym, b.y1}}};
  for (const auto& y : ys) {
    if (y[0] == y[1] && b.y0 != b.y1) continue;
    for (const auto& x : xs) {
      if (x[0] == x[1] && b.x0 != b.x1) continue;
      next.push_back({b.chart, x[0], y[0], x[1], y[1]});
    }
  }
}

}  // namespace lightbatch::lightmap
