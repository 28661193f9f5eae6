#include "core/accuracy/seams.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/atlas/weld.h"
#include "core/base/parallel.h"
#include "core/lightmap/look_up.h"

namespace lightbatch::accuracy {
namespace {

using scene::kNone;

constexpr double kFlat = 0.99985;   // cosine of 1 degree
constexpr double kFolded = 0.9848;  // of 10 degrees
/// Points on one edge at most: a wall of a kilometre is known well enough by them.
constexpr int kMostPoints = 1024;
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

/// A place on a triangle as the viewer's interpolation finds it.
struct Place {
  std::uint32_t triangle = kNone;
  float u = 0, v = 0;
};

Place on_edge(std::uint32_t triangle, std::size_t from, double s) {
  std::array<double, 3> weight{};
  weight[from] = 1 - s;
  weight[(from + 1) % 3] = s;
  return {triangle, static_cast<float>(weight[1]), static_cast<float>(weight[2])};
}

struct Step {
  double metres = 0;
  double size = 0;  // lux
  bool flat = false;
};

/// What one block of triangles found.
struct Found {
  std::vector<Step> steps;
  double divided = 0;
};

class Borders {
 public:
  Borders(const scene::Scene& scene, const rays::Caster& caster, const atlas::Layout& layout,
          const atlas::TexelMap& texels, const std::vector<lightmap::PageImage>& pages)
      : scene_(scene),
        caster_(caster),
        layout_(layout),
        texels_(texels),
        pages_(pages),
        texel_(1 / layout.texels_per_metre) {
    for (std::uint32_t t = 0; t < layout.chart_of.size(); ++t) {
      if (layout.chart_of[t] != kNone) lit_.push_back(t);
    }
    mesh_ = atlas::weld(scene, lit_);
  }

  Found follow() const {
    return deterministic_reduce(
        mesh_.size(), 1024, Found{},
        [&](std::size_t begin, std::size_t end) {
          Found found;
          for (std::size_t t = begin; t < end; ++t) {
            for (std::size_t k = 0; k < 3; ++k) {
              follow_edge(static_cast<std::uint32_t>(t), k, found);
            }
          }
          return found;
        },
        [](Found a, Found b) {
          a.steps.insert(a.steps.end(), b.steps.begin(), b.steps.end());
          a.divided += b.divided;
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

  void follow_edge(std::uint32_t t, std::size_t k, Found& found) const {
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
    const int points = std::clamp(static_cast<int>(std::ceil(metres / texel_)), 1, kMostPoints);
    for (int i = 0; i < points; ++i) {
      const double s = (i + 0.5) / points;
      const Vec3d at = from + along * s;
      const Place here = on_edge(own, k, s);
      Place there;
      double stands_for = metres / points;
      if (twin != kNone) {
        there = on_edge(other, twin % 3, 1 - s);
      } else {
        there = beside(own, at, outwards, normal);
        if (there.triangle == kNone) continue;
        stands_for /= 2;  // seen from the other side again
      }
      if (divided(at, outwards, normal)) {
        found.divided += stands_for;
        continue;
      }
      const Rgb d = shown(here) - shown(there);
      found.steps.push_back({stands_for,
                             std::sqrt(static_cast<double>(d.r * d.r + d.g * d.g + d.b * d.b) / 3),
                             cosine >= kFlat});
    }
  }

  Rgb shown(const Place& p) const {
    return lightmap::irradiance_at(layout_, pages_, p.triangle, p.u, p.v);
  }

  /// The same surface beyond an open edge, when it belongs to another chart.
  Place beside(std::uint32_t own, const Vec3d& at, const Vec3d& outwards,
               const Vec3d& normal) const {
    const Vec3d start = at + outwards * (kBeside * texel_) + normal * (kAbove * texel_);
    const rays::Ray down{to_float(start), to_float(normal * -1.0), 0.0f,
                         static_cast<float>(2 * kAbove * texel_)};
    const rays::Hit hit = caster_.closest(down, own);
    if (!hit.found() || layout_.chart_of[hit.triangle] == kNone) return {};
    if (layout_.chart_of[hit.triangle] == layout_.chart_of[own]) return {};
    if (hit.back != back(hit.triangle)) return {};
    if (std::fabs(static_cast<double>(hit.t) - kAbove * texel_) > kOnPlane * texel_) return {};
    const auto c = scene_.corners(hit.triangle);
    const Vec3d a = to_double(c[0]);
    const Vec3d n = cross(to_double(c[1]) - a, to_double(c[2]) - a);
    if (std::fabs(dot(n, normal)) < kFlat * length(n)) return {};
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
  const std::vector<lightmap::PageImage>& pages_;
  double texel_;  // metres
  std::vector<std::uint32_t> lit_;
  atlas::Mesh mesh_;
};

StepFigures figures_of(std::vector<Step> steps, double mean) {
  StepFigures figures;
  if (steps.empty() || !(mean > 0)) return figures;
  double squares = 0;
  for (const Step& s : steps) {
    figures.metres += s.metres;
    squares += s.metres * s.size * s.size;
  }
  std::sort(steps.begin(), steps.end(),
            [](const Step& a, const Step& b) { return a.size < b.size; });
  double below = 0;
  for (const Step& s : steps) {
    below += s.metres;
    figures.p95 = s.size / mean;
    if (below >= 0.95 * figures.metres) break;
  }
  figures.points = steps.size();
  figures.rms = std::sqrt(squares / figures.metres) / mean;
  figures.largest = steps.back().size / mean;
  return figures;
}

}  // namespace

Seams measure_seams(const scene::Scene& scene, const rays::Caster& caster,
                    const atlas::Layout& layout, const atlas::TexelMap& texels,
                    const std::vector<lightmap::PageImage>& pages, double mean_irradiance) {
  Seams seams;
  if (layout.charts.empty()) return seams;
  Found found = Borders(scene, caster, layout, texels, pages).follow();
  const auto folded = std::stable_partition(found.steps.begin(), found.steps.end(),
                                            [](const Step& s) { return s.flat; });
  seams.flat = figures_of({found.steps.begin(), folded}, mean_irradiance);
  seams.folded = figures_of({folded, found.steps.end()}, mean_irradiance);
  seams.divided_metres = found.divided;
  return seams;
}

}  // namespace lightbatch::accuracy
