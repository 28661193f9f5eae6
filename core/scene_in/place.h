#pragma once

#include <vector>

#include "core/scene/scene.h"
#include "core/scene_in/primitive.h"

namespace lightbatch::scene_in {

/// Metres. Areas and squared distances of the scene must stay finite floats.
constexpr double kLargestScene = 1e15;

/// One object to be: which primitive, where.
struct Placement {
  scene::Object object;  // everything but its triangles
  std::size_t primitive = 0;
};

/// Drops triangles without area and objects left with none, and transforms the rest into scene's
/// arrays, relative to scene.origin: near the middle of them, on a coarse grid of powers of two, so
/// that coordinates with few digits keep them. Parallel; the order of the result is that of
/// placements. INPUT_MALFORMED when the scene is too large for floats.
Status place_objects(const std::vector<Placement>& placements,
                     const std::vector<Primitive>& primitives, bool uv0, bool uv1,
                     const std::string& file, scene::Scene& scene);

}  // namespace lightbatch::scene_in
