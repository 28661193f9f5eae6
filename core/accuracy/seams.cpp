#include "core/accuracy/seams.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/lightmap/borders.h"
#include "core/lightmap/look_up.h"

namespace lightbatch::accuracy {
namespace {

struct Step {
  double metres = 0;
  double size = 0;  // lux
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
  const lightmap::Borders borders = lightmap::find_borders(scene, caster, layout, texels, {0.5});
  const auto shown = [&](const atlas::SurfacePoint& p) {
    return lightmap::irradiance_at(layout, pages, p.triangle, p.u, p.v);
  };
  std::vector<Step> flat, folded;
  for (const lightmap::BorderPoint& point : borders.points) {
    const Rgbd d = to_double(shown(point.here) - shown(point.there));
    const double size = std::sqrt((d.r * d.r + d.g * d.g + d.b * d.b) / 3);
    (point.flat ? flat : folded).push_back({point.metres, size});
  }
  return {figures_of(std::move(flat), mean_irradiance),
          figures_of(std::move(folded), mean_irradiance), borders.divided_metres};
}

}  // namespace lightbatch::accuracy
