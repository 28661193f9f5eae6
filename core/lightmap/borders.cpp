#include "core/lightmap/borders.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/atlas/weld.h"
#include "core/base/parallel.h"

namespace lightbatch::lightmap {
namespace {

using scene::kNone;

constexpr double kFlat = 0.99985;   // cosine of 1 degree
constexpr double kFolded = 0.9848;  // of 10 degrees
/// Stretches of one edge at most: a wall of a kilometre is known well enough by them.
constexpr int kMostStretches = 1024;
/// In texels: how far beside an open edge its neighbour is looked for, ...
constexpr double kBeside = 0.05;
/// ... from how far above the surface, ...
constexpr double kAbove = 0.25;
/// ... how far off the plane two surfaces are still one, ...
constexpr double kOnPlane = 0.01;
/// ... and how far on each side of the border it must be open above the surface.
constexpr double kAside = 0.5;
/// Coordinates of the same place in one chart differ by no more, in texels.
constexpr float kSamePlace = 1e-3f;

atlas::SurfacePoint on_edge(std::uint32_t triangle, std::size_t from, double s) {
  std::array<double, 3> weight{};
  weight[from] = 1 - s;
  weight[(from + 1) % 3] = s;
  return {triangle, static_cast<float>(weight[1]), static_cast<float>(weight[2])};
}

class BorderFinder {
 public:
  BorderFinder(const scene::Scene& scene, const rays::Caster& caster, const atlas::Layout& layout,
               const atlas::TexelMap& texels, const std::vector<double>& phases)
      : scene_(scene),
        caster_(caster),
        layout_(layout),
        texels_(texels),
        phases_(phases),
        texel_(1 / layout.texels_per_metre) {
    for (std::uint32_t t = 0; t < layout.chart_of.size(); ++t) {
      if (layout.chart_of[t] != kNone) lit_.push_back(t);
    }
    mesh_ = atlas::weld(scene, lit_);
  }

  Borders run() const {
    return deterministic_reduce(
        mesh_.size(), 1024, Borders{},
        [&](std::size_t begin, std::size_t end) {
          Borders found;
          for (std::size_t t = begin; t < end; ++t) {
            for (std::size_t k = 0; k < 3; ++k) {
              follow_edge(static_cast<std::uint32_t>(t), k, found);
            }
          }
          return found;
        },
        [](Borders a, Borders b) {
          a.points.insert(a.points.end(), b.points.begin(), b.points.end());
          a.divided_metres += b.divided_metres;
          return a;
        });
  }

 private:
  std::uint32_t source(std::uint32_t mesh_triangle) const {
    return lit_[mesh_.source[mesh_triangle]];
  }
  bool back(std::uint32_t triangle) const { return texels_.is_back(layout_.chart_of[triangle]); }

  /// One chart, and the edge lies in one place of it.
  bool continuous(std::uint32_t a, std::size_t k, std::uint32_t b, std::size_t j) const {
    if (layout_.chart_of[a] != layout_.chart_of[b]) return false;
    const auto same = [](Vec2f p, Vec2f q) {
      return std::max(std::fabs(p.x - q.x), std::fabs(p.y - q.y)) <= kSamePlace;
    };
    return same(layout_.uv[a][k], layout_.uv[b][(j + 1) % 3]) &&
           same(layout_.uv[a][(k + 1) % 3], layout_.uv[b][j]);
  }

  void follow_edge(std::uint32_t t, std::size_t k, Borders& found) const {
    const std::uint32_t own = source(t);
    const std::uint32_t twin = mesh_.twin[3 * t + k];
    const std::uint32_t other = twin == kNone ? kNone : source(twin / 3);
    double cosine = 1;
    if (twin != kNone) {
      if (twin < 3 * t + k || continuous(own, k, other, twin % 3)) return;  // once an edge
      cosine = dot(mesh_.normals[t], mesh_.normals[twin / 3]);
      if (cosine < kFolded || back(own) != back(other)) return;
    }
    const Vec3d from = mesh_.points[mesh_.corners[t][k]];
    const Vec3d along = mesh_.points[mesh_.corners[t][(k + 1) % 3]] - from;
    const double metres = length(along);
    const Vec3d normal = mesh_.normals[t] * (back(own) ? -1.0 : 1.0);
    const Vec3d outwards = cross(along, mesh_.normals[t]) / metres;
    const int stretches =
        std::clamp(static_cast<int>(std::ceil(metres / texel_)), 1, kMostStretches);
    for (int i = 0; i < stretches; ++i) {
      for (const double phase : phases_) {
        const double s = (i + phase) / stretches;
        const Vec3d at = from + along * s;
        BorderPoint point{on_edge(own, k, s), {}, 0, cosine >= kFlat};
        point.metres = metres / (stretches * static_cast<double>(phases_.size()));
        if (twin != kNone) {
          point.there = on_edge(other, twin % 3, 1 - s);
        } else {
          point.there = beside(own, at, outwards, normal);
          if (point.there.triangle == kNone) continue;
          point.metres /= 2;  // seen from the other side again
        }
        if (divided(at, outwards, normal)) {
          found.divided_metres += point.metres;
        } else {
          found.points.push_back(point);
        }
      }
    }
  }

  /// The same surface beyond an open edge, when it belongs to another chart.
  atlas::SurfacePoint beside(std::uint32_t own, const Vec3d& at, const Vec3d& outwards,
                             const Vec3d& normal) const {
    constexpr atlas::SurfacePoint kNothing{kNone, 0, 0};
    const Vec3d start = at + outwards * (kBeside * texel_) + normal * (kAbove * texel_);
    const rays::Ray down{to_float(start), to_float(normal * -1.0), 0.0f,
                         static_cast<float>(2 * kAbove * texel_)};
    const rays::Hit hit = caster_.closest(down, own);
    if (!hit.found() || layout_.chart_of[hit.triangle] == kNone) return kNothing;
    if (layout_.chart_of[hit.triangle] == layout_.chart_of[own]) return kNothing;
    if (hit.back != back(hit.triangle)) return kNothing;
    if (std::fabs(static_cast<double>(hit.t) - kAbove * texel_) > kOnPlane * texel_) {
      return kNothing;
    }
    const auto c = scene_.corners(hit.triangle);
    const Vec3d a = to_double(c[0]);
    const Vec3d n = cross(to_double(c[1]) - a, to_double(c[2]) - a);
    if (std::fabs(dot(n, normal)) < kFlat * length(n)) return kNothing;
    return {hit.triangle, hit.u, hit.v};
  }

  /// Something stands on the border, or hangs within a texel above it: light may change there.
  bool divided(const Vec3d& at, const Vec3d& outwards, const Vec3d& normal) const {
    for (const double above : {kAbove, 1.0}) {
      const Vec3d start = at - outwards * (kAside * texel_) + normal * (above * texel_);
      const rays::Ray across{to_float(start), to_float(outwards), 0.0f,
                             static_cast<float>(2 * kAside * texel_)};
      if (caster_.occluded(across)) return true;
    }
    return false;
  }

  const scene::Scene& scene_;
  const rays::Caster& caster_;
  const atlas::Layout& layout_;
  const atlas::TexelMap& texels_;
  const std::vector<double>& phases_;
  double texel_;  // metres
  std::vector<std::uint32_t> lit_;
  atlas::Mesh mesh_;
};

}  // namespace

Borders find_borders(const scene::Scene& scene, const rays::Caster& caster,
                     const atlas::Layout& layout, const atlas::TexelMap& texels,
                     const std::vector<double>& phases) {
  if (layout.charts.empty()) return {};
  return BorderFinder(scene, caster, layout, texels, phases).run();
}

}  // namespace lightbatch::lightmap
