#pragma once

#include <string>
#include <vector>

#include "core/gltf/document.h"
#include "core/gltf/json_path.h"

namespace lightbatch::gltf {

/// Cameras are passed through: a camera without the object of its type is refused, odd values are
/// worth a warning.
Status check_cameras(const Json& json, const JsonPath& root, std::vector<std::string>& warnings);

/// KHR_lights_punctual: a spot needs its "spot" object; angles out of order are worth a warning.
Status check_lights(const Json& json, const JsonPath& root, std::vector<std::string>& warnings);

}  // namespace lightbatch::gltf
