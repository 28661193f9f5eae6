#pragma once

#include "core/gltf/document.h"
#include "core/gltf/json_path.h"

namespace lightbatch::gltf {

/// Skins: an inverse bind matrix for each joint, joints of one tree, and a skeleton root above them
/// all. Call after check_nodes().
Status check_skins(const Document& document, const JsonPath& root);

}  // namespace lightbatch::gltf
