#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/atlas/grid.h"
#include "core/atlas/layout.h"

namespace lightbatch::atlas {

/// Fragment::area of triangles that collapsed to a line or point.
constexpr float kCollapsedArea = 1e-9f;

/// The part of one triangle inside one texel.
struct Fragment {
  std::uint32_t triangle = 0;
  /// Covered samples of the texel's 4 x 4 grid (bit 4 j + i: sample ((i + .5) / 4, (j + .5) / 4));
  /// exact fill rule, so that neighbours in one chart never share a sample. May be 0 when the
  /// triangle touches the texel between samples.
  std::uint16_t mask = 0;
  float area = 0;  // of triangle and texel's intersection, in texels, in (0, 1]
  Vec2f centroid;  // of that intersection, page texel coordinates
  /// m2 of the triangle that lie in the texel: the weight of the fragment in the texel's mean, in
  /// every case. Over all fragments of a triangle it sums to the triangle's own area. Triangles
  /// whose coordinates collapsed to a line or point (smaller than half a texel) have it too; their
  /// `area` is a token kCollapsedArea and their mask 0.
  float surface = 0;
};

struct Texel {
  std::uint32_t chart = 0;
  std::uint16_t page = 0;
  std::uint16_t x = 0;
  std::uint16_t y = 0;
  std::uint32_t fragment_count = 0;
  std::uint32_t first_fragment = 0;
  float coverage = 0;  // sum of fragment areas, at most about 1
};

/// All texels that some surface covers, sorted by page, row, column.
struct TexelMap {
  std::vector<Texel> texels;
  std::vector<Fragment> fragments;
  std::vector<std::vector<std::uint32_t>> index;  // per page: width * height -> texel or kNone
  /// Per chart: 1 where its texels hold the light of the clockwise side; empty: nowhere.
  std::vector<std::uint8_t> back;

  /// m2 of surface in the texel.
  double surface_of(const Texel& t) const {
    double sum = 0;
    for (const Fragment& f : fragments_of(t)) sum += static_cast<double>(f.surface);
    return sum;
  }
  bool is_back(std::uint32_t chart) const { return !back.empty() && back[chart] != 0; }

  std::span<const Fragment> fragments_of(const Texel& t) const {
    return std::span(fragments).subspan(t.first_fragment, t.fragment_count);
  }
};

/// A point on the surface: position = barycentric mix of the triangle's corners.
struct SurfacePoint {
  std::uint32_t triangle = 0;
  float u = 0, v = 0;  // weights of corners 1 and 2; corner 0 has 1 - u - v (clamped to inside)
};

/// Exact coverage of every texel by the laid-out triangles. Deterministic; parallel.
TexelMap cover_texels(const scene::Scene& scene, const Layout& layout);

/// A laid-out triangle, made once to look up many of its points.
class PageTriangle {
 public:
  PageTriangle(const Layout& layout, std::uint32_t triangle);
  /// The surface point at page coordinates (clamped to the triangle). On a triangle that collapsed
  /// to a line: the middle of the section that the line's point stands for.
  SurfacePoint at(Vec2f page_uv) const;

 private:
  std::uint32_t triangle_;
  GridTriangle corner_;
  std::int64_t twice_area_;
};

inline SurfacePoint point_at(const Layout& layout, std::uint32_t triangle, Vec2f page_uv) {
  return PageTriangle(layout, triangle).at(page_uv);
}

}  // namespace lightbatch::atlas
