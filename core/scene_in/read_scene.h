#pragma once

#include "core/base/status.h"
#include "core/gltf/document.h"
#include "core/scene/scene.h"

namespace lightbatch::scene_in {

/// Builds the world-space scene of the document's default scene (scene 0 when none is named).
/// Instances are expanded; skinned, morphing and animated nodes (and what hangs below animated
/// ones), LINES and POINTS are listed in Scene::skipped. Textures whose pixels matter to light
/// (base colour, emission, metallic, transmission, alpha) are decoded.
Result<scene::Scene> read_scene(const gltf::Document& document,
                                const gltf::ReadLimits& limits = {});

}  // namespace lightbatch::scene_in
