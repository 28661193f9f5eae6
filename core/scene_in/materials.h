#pragma once

#include <string>

#include "core/scene/scene.h"
#include "core/scene_in/model.h"
#include "core/scene_in/textures.h"

namespace lightbatch::scene_in {

/// One glTF material (kNone: the default one) as light sees it. Factors out of their range are
/// clamped, with a warning. Textures whose factor makes them invisible get no slot.
scene::Material read_material(const tinygltf::Model& model, std::uint32_t index,
                              const std::string& file, TextureReader& textures,
                              std::vector<std::string>& warnings);

}  // namespace lightbatch::scene_in
