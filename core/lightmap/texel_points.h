#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "core/atlas/texel_part.h"
#include "core/atlas/texels.h"
#include "core/optics/surface_frame.h"
#include "core/radiosity/direct_light.h"
#include "core/scene/scene.h"

namespace lightbatch::lightmap {

/// Where a texel is measured: covered samples of its 4 x 4 grid, or, when none is covered, as in
/// charts smaller than half a texel, parts of the fragments. Each stands for an equal share of the
/// surface; the first few of many are spread evenly.
struct TexelPoints {
  struct Point {
    std::uint32_t triangle = 0;
    Vec2f at;           // page coordinates; of parts: their fragment's centroid
    bool back = false;  // the clockwise side
    /// The fragment is cut into so many parts of equal area; 0: the point is `at`.
    std::uint8_t part = 0, parts = 0;
  };
  std::array<Point, 16> point;
  std::uint32_t count = 0;
};

TexelPoints texel_points(const atlas::TexelMap& map, const atlas::Texel& texel);

/// Whether the shares of two of a texel's points touch.
inline bool adjacent(const TexelPoints::Point& a, const TexelPoints::Point& b) {
  constexpr float kNext = 0.3f;  // a sixteenth is a quarter of a texel across
  return std::fabs(a.at.x - b.at.x) < kNext && std::fabs(a.at.y - b.at.y) < kNext;
}

/// The covered point nearest to the centroid of the texel's surface.
TexelPoints::Point central_point(const atlas::TexelMap& map, const atlas::Texel& texel);

/// The point moved by a part of a sample's share, (x, y) in [0, 1)^2 about the middle. A point that
/// would leave its triangle is moved the other way, or stays where it is (beyond an edge may lie
/// another room). Parts stay as they are.
TexelPoints::Point moved_within(const atlas::Layout& layout, const TexelPoints::Point& point,
                                Vec2f by);

/// The point on the surface, moved by a part of its share as moved_within does, parts too.
atlas::SurfacePoint surface_point(const atlas::Layout& layout, const TexelPoints::Point& point,
                                  Vec2f by = {0.5f, 0.5f});

/// The texel's side of the surface at a point of it, ready to cast from.
radiosity::Receiver receiver_at(const scene::Scene& scene, const atlas::Layout& layout,
                                const TexelPoints::Point& point, float lift);

/// The same for many points, few of which in a row lie on different triangles; moved as
/// surface_point does.
class Receivers {
 public:
  Receivers(const scene::Scene& scene, const atlas::Layout& layout, float lift)
      : scene_(scene), layout_(layout), lift_(lift) {}

  radiosity::Receiver operator()(const TexelPoints::Point& point, Vec2f moved_by);

 private:
  const scene::Scene& scene_;
  const atlas::Layout& layout_;
  float lift_;
  std::uint32_t triangle_ = scene::kNone;
  std::optional<atlas::PageTriangle> on_page_;
  std::optional<atlas::TexelPart> part_;  // of the triangle, in the texel of part_of_
  Vec2f part_of_;
  std::optional<optics::TriangleFrame> frame_;
};

}  // namespace lightbatch::lightmap
