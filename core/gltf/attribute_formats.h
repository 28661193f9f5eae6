#pragma once

#include <string>
#include <string_view>

#include "core/gltf/layout.h"

namespace lightbatch::gltf {

/// What the name of a vertex attribute demands of its accessor (glTF 3.7.2.1 and
/// KHR_mesh_quantization).
enum class AttributeFault { kNone, kUnknownName, kWrongType, kWrongComponents, kNeedsQuantization };

/// `target`: of a morph target, where TANGENT has three components.
AttributeFault check_attribute_format(std::string_view name, const Layout& layout, bool target,
                                      bool quantized);

}  // namespace lightbatch::gltf
