#pragma once

#include <optional>

#include "core/accuracy/path_tracer.h"
#include "core/lightmap/bake.h"
#include "core/lightmap/dim.h"
#include "core/lightmap/gather.h"
#include "core/radiosity/solver.h"
#include "tests/unit/accuracy/scene_kit.h"

namespace lightbatch::lightmap {

/// A scene put together in code with its first stage solved: what a gather reads.
class LitScene {
 public:
  accuracy::SceneKit kit;
  optics::Environment sky;
  atlas::Layout layout;  // empty unless the test fills it
  atlas::TexelMap texels;
  double edge = 0.25;  // of elements, metres
  int rays = 256;      // stored, of an element

  /// Gives every triangle texels.
  void chart(double texels_per_metre) {
    atlas::LayoutOptions options;
    options.texels_per_metre = texels_per_metre;
    const std::vector<std::uint8_t> lit(kit.scene().triangles.size(), 1);
    for (const Vec3f& p : kit.scene().positions) kit.scene().box.add(p);
    auto made = atlas::make_layout(kit.scene(), lit, options, Progress{});
    layout = std::move(made).value();
    texels = atlas::cover_texels(kit.scene(), layout);
  }

  /// Call once everything is in.
  void solve() {
    kit.finish();
    sources_.emplace(kit.scene(), kit.optics(), radiosity::LightSources::Kinds{});
    direct_.emplace(kit.optics(), kit.caster(), *sources_);
    elements_.emplace(kit.scene(), kit.tree(), kit.optics(),
                      radiosity::ElementOptions{edge, 4'000'000});
    lookup_.emplace(kit.scene(), kit.caster(), *elements_, direct_->lift());
    radiosity::SolverOptions options;
    options.rays = rays;
    options.direct_samples = 32;
    auto solution = radiosity::solve_stored_rays(
        {kit.scene(), kit.tree(), kit.optics(), kit.caster(), *elements_, *direct_, sky, *lookup_},
        options, Progress{});
    solution_ = std::move(solution).value();
    double light = 0, area = 0;
    for (radiosity::ElementId e = 0; e < elements_->count(); ++e) {
      const auto a = static_cast<double>(elements_->area(e));
      light += a * static_cast<double>(solution_.irradiance[e].sum()) / 3;
      area += a;
    }
    mean_ = area > 0 ? light / area : 0;
  }

  /// A texel's points for path tracing.
  std::vector<accuracy::SurfacePoint> points_of(std::uint32_t texel) const {
    const TexelPoints grid = texel_points(texels, texels.texels[texel]);
    std::vector<accuracy::SurfacePoint> points;
    for (std::uint32_t i = 0; i < grid.count; ++i) {
      const auto at = surface_point(layout, grid.point[i]);
      points.push_back({at.triangle, at.u, at.v, false});
    }
    return points;
  }

  BakeInput input() const {
    BakeInput input{const_cast<accuracy::SceneKit&>(kit).scene(),
                    kit.optics(),
                    kit.caster(),
                    sky,
                    *direct_,
                    *elements_,
                    *lookup_,
                    solution_,
                    layout,
                    texels};
    input.mean_irradiance = mean_;
    return input;
  }

 private:
  std::optional<radiosity::LightSources> sources_;
  std::optional<radiosity::DirectLight> direct_;
  std::optional<radiosity::Elements> elements_;
  std::optional<radiosity::ElementLookup> lookup_;
  radiosity::Solution solution_;
  double mean_ = 0;
};

}  // namespace lightbatch::lightmap
