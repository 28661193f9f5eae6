#pragma once

#include <string>
#include <vector>

#include "core/gltf/document.h"
#include "core/gltf/json_path.h"

namespace lightbatch::gltf {

/// Animations and skins: sampler indices, accessor types and counts.
Status check_animations(const Document& document, const JsonPath& root);
Status check_skins(const Document& document, const JsonPath& root);

}  // namespace lightbatch::gltf
