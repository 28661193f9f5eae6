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

/// Chooses the origin near the middle of everything, on a coarse grid of powers of two, so that
/// coordinates with few digits keep them. INPUT_MALFORMED when the scene is too large for floats.
Result<Vec3d> choose_origin(const std::vector<Placement>& placements,
                            const std::vector<Primitive>& primitives, const std::string& file);

/// Transforms every placement into scene's arrays (positions relative to scene.origin), drops
/// triangles without area and objects left with none. Parallel; the order of the result is that of
/// placements.
void place_objects(const std::vector<Placement>& placements,
                   const std::vector<Primitive>& primitives, bool uv0, bool uv1,
                   scene::Scene& scene);

}  // namespace lightbatch::scene_in
