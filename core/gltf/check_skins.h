#pragma once

#include <string>
#include <vector>

#include "core/gltf/document.h"
#include "core/gltf/json_path.h"

namespace lightbatch::gltf {

/// Skins: an inverse bind matrix for each joint, and a skeleton root above them all; joints of
/// several trees are worth a warning. Call after check_nodes().
Status check_skins(const Document& document, const JsonPath& root,
                   std::vector<std::string>& warnings);

}  // namespace lightbatch::gltf
