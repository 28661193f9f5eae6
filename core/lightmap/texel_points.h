#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/atlas/texels.h"
#include "core/optics/surface_frame.h"
#include "core/radiosity/direct_light.h"
#include "core/scene/scene.h"

namespace lightbatch::lightmap {

/// Where a texel is measured: covered samples of its 4 x 4 grid (each stands for an equal share
/// of the surface), or a sample of the fragments by surface when no sample is covered. The first
/// few of many are spread evenly.
struct TexelPoints {
  struct Point {
    std::uint32_t triangle = 0;
    Vec2f at;           // page coordinates
    bool back = false;  // the clockwise side
  };
  std::array<Point, 16> point;
  std::uint32_t count = 0;
};

TexelPoints texel_points(const atlas::TexelMap& map, const atlas::Texel& texel);

/// The covered point nearest to the centroid of the texel's surface.
TexelPoints::Point central_point(const atlas::TexelMap& map, const atlas::Texel& texel);

/// The point moved by a part of a sample's share, (x, y) in [0, 1)^2 about the middle. A point that
/// would leave its triangle is moved the other way, or stays where it is (beyond an edge may lie
/// another room).
TexelPoints::Point moved_within(const atlas::Layout& layout, const TexelPoints::Point& point,
                                Vec2f by);

/// The texel's side of the surface at a point of it, ready to cast from.
radiosity::Receiver receiver_at(const scene::Scene& scene, const atlas::Layout& layout,
                                const TexelPoints::Point& point, float lift);

/// The same for many points, few of which in a row lie on different triangles; moved as
/// moved_within does.
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
  std::optional<optics::TriangleFrame> frame_;
};

}  // namespace lightbatch::lightmap
