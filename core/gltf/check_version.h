#pragma once

#include <string>
#include <vector>

#include "core/gltf/document.h"
#include "core/gltf/json_path.h"

namespace lightbatch::gltf {

/// Version "2.x" is read, other major versions are refused. Comes before everything else is looked
/// at, since glTF 1 differs in every list.
Status check_version(const Json& json, const JsonPath& root, std::vector<std::string>& warnings);

}  // namespace lightbatch::gltf
