#pragma once

#include <cstdint>
#include <vector>

#include "core/gltf/document.h"

namespace lightbatch::gltf {

/// For each material: the sets of texture coordinates its textures use, KHR_texture_transform's
/// override taken into account.
std::vector<std::vector<std::uint32_t>> texture_coordinates_needed(const Json& json);

}  // namespace lightbatch::gltf
