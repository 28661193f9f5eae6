#include "core/lightmap/texel_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "core/atlas/verify.h"
namespace lightbatch::lightmap {
namespace {

/// The 4 x 4 grid in four Latin squares: the first four, eight and twelve are spread evenly.
constexpr unsigned kSpread[] = {1, 7, 8, 14, 2, 4, 11, 13, 0, 6, 9, 15, 3, 5, 10, 12};

/// Sixteen in the order of their reversed bits.
constexpr unsigned kReversed[] = {0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15};

Vec2f within_texel(const Vec2f& at, const atlas::Texel& texel) {
  const Vec2f low{static_cast<float>(texel.x), static_cast<float>(texel.y)};
  return {std::clamp(at.x, low.x, std::nextafter(low.x + 1, 0.0f)),
          std::clamp(at.y, low.y, std::nextafter(low.y + 1, 0.0f))};
}

Vec2f grid_sample(const atlas::Texel& texel, unsigned bit) {
  return {static_cast<float>(texel.x) + (static_cast<float>(bit & 3u) + 0.5f) * 0.25f,
          static_cast<float>(texel.y) + (static_cast<float>(bit >> 2) + 0.5f) * 0.25f};
}

/// Parts of the fragments by surface, sixteen in all.
void add_parts(std::span<const atlas::Fragment> fragments, const atlas::Texel& texel, bool back,
               TexelPoints& points) {
  constexpr std::size_t kCount = 16;
  double total = 0, below = 0;
  for (const atlas::Fragment& f : fragments) total += static_cast<double>(f.surface);
  std::array<TexelPoints::Point, kCount> in_order;
  std::size_t count = 0;
  for (const atlas::Fragment& f : fragments) {
    below += static_cast<double>(f.surface);
    const double reached = total > 0 ? below / total * kCount : kCount;
    const std::size_t first = count;
    while (count < kCount && static_cast<double>(count) + 0.5 < reached) {
      in_order[count++] = {f.triangle, within_texel(f.centroid, texel), back};
    }
    for (std::size_t i = first; i < count; ++i) {
      in_order[i].part = static_cast<std::uint8_t>(i - first);
      in_order[i].parts = static_cast<std::uint8_t>(count - first);
    }
  }
  for (const unsigned i : kReversed) {
    if (i < count) points.point[points.count++] = in_order[i];
  }
}

/// Of the unit square that a fragment is spread over: the point's part, moved. Columns of about as
/// many parts as there are columns.
Vec2f place_in_square(const TexelPoints::Point& point, Vec2f by) {
  const unsigned parts = point.parts;
  const auto columns = static_cast<unsigned>(std::sqrt(static_cast<float>(parts)) + 0.5f);
  const unsigned each = parts / columns, longer = parts % columns;
  unsigned column = 0, first = 0, size = 0;
  for (; column < columns; ++column, first += size) {
    size = each + (column < longer ? 1 : 0);
    if (point.part < first + size) break;
  }
  const auto whole = static_cast<float>(parts), rows = static_cast<float>(size);
  return {(static_cast<float>(first) + by.x * rows) / whole,
          (static_cast<float>(point.part - first) + by.y) / rows};
}

Vec2f texel_of(const Vec2f& at) { return {std::floor(at.x), std::floor(at.y)}; }

atlas::TexelPart part_at(const atlas::Layout& layout, const TexelPoints::Point& point) {
  const Vec2f texel = texel_of(point.at);
  return {atlas::grid_triangle(layout, point.triangle), static_cast<std::int32_t>(texel.x),
          static_cast<std::int32_t>(texel.y)};
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
  add_parts(map.fragments_of(texel), texel, back, points);
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
  TexelPoints::Point point = points.point[best];
  point.part = point.parts = 0;
  return point;
}

TexelPoints::Point moved_within(const atlas::Layout& layout, const TexelPoints::Point& point,
                                Vec2f by) {
  if (point.parts > 0) return point;
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

atlas::SurfacePoint surface_point(const atlas::Layout& layout, const TexelPoints::Point& point,
                                  Vec2f by) {
  if (point.parts == 0) {
    return atlas::point_at(layout, point.triangle, moved_within(layout, point, by).at);
  }
  const Vec2f p = part_at(layout, point).at(place_in_square(point, by));
  return {point.triangle, p.x, p.y};
}

radiosity::Receiver Receivers::operator()(const TexelPoints::Point& point, Vec2f moved_by) {
  if (point.triangle != triangle_) {
    triangle_ = point.triangle;
    on_page_.emplace(layout_, triangle_);
    frame_.emplace(scene_, triangle_);
    part_.reset();
  }
  if (point.parts > 0) {
    if (!part_ || !(part_of_ == texel_of(point.at))) {
      part_ = part_at(layout_, point);
      part_of_ = texel_of(point.at);
    }
    const Vec2f p = part_->at(place_in_square(point, moved_by));
    return {frame_->at(p.x, p.y, point.back, lift_), triangle_};
  }
  const atlas::SurfacePoint p = on_page_->at(moved_within(layout_, point, moved_by).at);
  return {frame_->at(p.u, p.v, point.back, lift_), triangle_};
}

radiosity::Receiver receiver_at(const scene::Scene& scene, const atlas::Layout& layout,
                                const TexelPoints::Point& point, float lift) {
  const atlas::SurfacePoint p = surface_point(layout, point);
  return {optics::surface_frame(scene, p.triangle, p.u, p.v, point.back, lift), p.triangle};
}

}  // namespace lightbatch::lightmap
