#pragma once

#include <cstdint>
#include <vector>

#include "core/atlas/layout.h"
#include "core/lightmap/texel_points.h"
#include "core/radiosity/light_sources.h"
#include "core/scene/scene.h"

namespace lightbatch::lightmap {

/// Whether a point or spot light that is close, or whose cone is narrow, brings light to a sphere
/// that is too uneven there for a few points to tell its mean.
bool varies_within(const radiosity::PunctualLight& light, const Vec3f& centre, float radius);

/// Part of a texel's sixteenth.
struct LampCell {
  Vec2f at;        // its middle, page coordinates
  float edge = 0;  // page coordinates
  Rgb light;       // lux, mean over the sixteenth of what falls into the cell, shadows apart
};

/// Cuts the sixteenth about a point so finely that the light varies little within a cell but for
/// the distance and the cosine, whose mean is the cell's solid angle; at sharp edges until the
/// texel is off by no more than `allowed`, lux. Cells without light are left out. Empty without
/// light, and where the triangle has collapsed on the page.
void cut_for_lamp(const radiosity::PunctualLight& light, const scene::Scene& scene,
                  const atlas::Layout& layout, const TexelPoints::Point& about, double allowed,
                  std::vector<LampCell>& cells);

}  // namespace lightbatch::lightmap
