#pragma once

#include <cstdint>
#include <vector>

#include "core/accuracy/path_tracer.h"
#include "core/atlas/layout.h"
#include "core/atlas/texels.h"
#include "core/base/progress.h"
#include "core/base/status.h"
#include "core/lightmap/pages.h"
#include "core/scene/scene.h"

namespace lightbatch::accuracy {

struct LeakOptions {
  double mean_irradiance = 0;  // lux, of the map
  double bright = 0.02;        // share of the mean above which a dark point must not be shown
  std::size_t points = 4096;   // to look at
  std::uint64_t seed = 1;
};

/// Light shown where there is none: points that no light reaches (below 1e-4 of the mean, by path
/// tracing) although the lightmap shows more than `bright` times the mean there.
struct Leaks {
  std::uint64_t points = 0;               // looked at
  std::uint64_t leaks = 0;                // of them: shown bright, but dark; scaled by the share
                                          // of some that stay dark when traced much longer
  double area_share = 0;                  // of the surface, estimated from them
  double largest = 0;                     // share of the mean, of those traced longer
  std::uint32_t triangle = scene::kNone;  // where that was
  std::uint64_t hidden = 0;  // also bright and dark, but in a crack narrower than a texel or inside
                             // a solid: nobody looks in there
};

/// Looks at random points, half of them on bright texels within two texels of a dark one (below
/// 1e-3 of the mean), where leaks arise, half on the rest of the surface. Reads the finished pages
/// as a viewer does. The same figures on any number of threads. CANCELLED.
Result<Leaks> find_leaks(const PathTracer& tracer, const rays::Caster& caster,
                         const scene::Scene& scene, const atlas::Layout& layout,
                         const atlas::TexelMap& texels,
                         const std::vector<lightmap::PageImage>& pages, const LeakOptions& options,
                         const Progress& progress);

}  // namespace lightbatch::accuracy
