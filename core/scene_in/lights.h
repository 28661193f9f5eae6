#pragma once

#include "core/scene/scene.h"
#include "core/scene_in/model.h"
#include "core/scene_in/nodes.h"

namespace lightbatch::scene_in {

/// Places the lights of KHR_lights_punctual. Intensities are not scaled by node transforms
/// (as the extension says); moving lights are listed in scene.skipped.
Status read_lights(const gltf::Document& document, const tinygltf::Model& model,
                   const NodeTree& tree, scene::Scene& scene);

}  // namespace lightbatch::scene_in
