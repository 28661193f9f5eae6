#include "core/lightmap/texel_points.h"

#include <algorithm>
#include <limits>

namespace lightbatch::lightmap {
namespace {

/// The 4 x 4 grid in four Latin squares: the first four, eight and twelve are spread evenly.
constexpr unsigned kSpread[] = {1, 7, 8, 14, 2, 4, 11, 13, 0, 6, 9, 15, 3, 5, 10, 12};

Vec2f grid_sample(const atlas::Texel& texel, unsigned bit) {
  return {static_cast<float>(texel.x) + (static_cast<float>(bit & 3u) + 0.5f) * 0.25f,
          static_cast<float>(texel.y) + (static_cast<float>(bit >> 2) + 0.5f) * 0.25f};
}

}  // namespace

TexelPoints texel_points(const atlas::TexelMap& map, const atlas::Texel& texel) {
  TexelPoints points;
  const bool back = map.is_back(texel.chart);
  for (const unsigned bit : kSpread) {
    for (const atlas::Fragment& f : map.fragments_of(texel)) {
      if ((f.mask >> bit & 1u) && points.count < points.point.size())
        points.point[points.count++] = {f.triangle, grid_sample(texel, bit), back};
    }
  }
  if (points.count > 0) return points;
  // Nothing but collapsed triangles: a systematic sample of them by surface.
  const auto fragments = map.fragments_of(texel);
  double total = 0;
  for (const atlas::Fragment& f : fragments) total += static_cast<double>(f.surface);
  const std::size_t wanted = std::min(fragments.size(), points.point.size());
  double below = 0;
  for (const atlas::Fragment& f : fragments) {
    below += static_cast<double>(f.surface);
    const double reached = total > 0 ? below / total * static_cast<double>(wanted) : 0;
    while (points.count < wanted && points.count + 0.5 < reached) {
      points.point[points.count++] = {f.triangle, f.centroid, back};
    }
  }
  if (points.count == 0)
    points.point[points.count++] = {fragments[0].triangle, fragments[0].centroid, back};
  return points;
}

TexelPoints::Point central_point(const atlas::TexelMap& map, const atlas::Texel& texel) {
  const auto fragments = map.fragments_of(texel);
  Vec2f sum{};
  float weight = 0;
  for (const atlas::Fragment& f : fragments) {
    sum = sum + f.centroid * f.area;
    weight += f.area;
  }
  const Vec2f centre = weight > 0 ? sum * (1.0f / weight) : fragments[0].centroid;
  if (fragments.size() == 1) {
    return {fragments[0].triangle, fragments[0].centroid, map.is_back(texel.chart)};
  }
  // Between fragments the centre may lie off the surface: take a point that is on it.
  const TexelPoints points = texel_points(map, texel);
  std::uint32_t best = 0;
  float nearest = std::numeric_limits<float>::infinity();
  for (std::uint32_t i = 0; i < points.count; ++i) {
    const Vec2f d = points.point[i].at - centre;
    const float distance = d.x * d.x + d.y * d.y;
    if (distance < nearest) {
      nearest = distance;
      best = i;
    }
  }
  return points.point[best];
}

TexelPoints::Point moved_within(const atlas::Layout& layout, const TexelPoints::Point& point,
                                Vec2f by) {
  const auto& uv = layout.uv[point.triangle];
  const float whole = cross(uv[1] - uv[0], uv[2] - uv[0]);
  const auto inside = [&](Vec2f at) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (cross(uv[(k + 1) % 3] - uv[k], at - uv[k]) * whole <= 0) return false;
    }
    return true;
  };
  const Vec2f step{(by.x - 0.5f) * 0.25f, (by.y - 0.5f) * 0.25f};
  for (const Vec2f at : {point.at + step, point.at - step}) {
    if (inside(at)) return {point.triangle, at, point.back};
  }
  return point;
}

radiosity::Receiver Receivers::operator()(const TexelPoints::Point& point, Vec2f moved_by) {
  if (point.triangle != triangle_) {
    triangle_ = point.triangle;
    on_page_.emplace(layout_, triangle_);
    frame_.emplace(scene_, triangle_);
  }
  const atlas::SurfacePoint p = on_page_->at(moved_within(layout_, point, moved_by).at);
  return {frame_->at(p.u, p.v, point.back, lift_), triangle_};
}

radiosity::Receiver receiver_at(const scene::Scene& scene, const atlas::Layout& layout,
                                const TexelPoints::Point& point, float lift) {
  const atlas::SurfacePoint p = atlas::point_at(layout, point.triangle, point.at);
  return {optics::surface_frame(scene, p.triangle, p.u, p.v, point.back, lift), p.triangle};
}

}  // namespace lightbatch::lightmap
