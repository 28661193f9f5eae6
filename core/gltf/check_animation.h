#pragma once

#include <string>
#include <vector>

#include "core/gltf/document.h"
#include "core/gltf/json_path.h"

namespace lightbatch::gltf {

/// Animations, which lightbatch passes on: samplers and targets exist, accessors have the type and
/// count that the target's property asks for, no property is animated twice.
Status check_animations(const Document& document, const JsonPath& root,
                        std::vector<std::string>& warnings);

}  // namespace lightbatch::gltf
