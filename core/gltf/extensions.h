#pragma once

#include "core/gltf/document.h"
#include "core/gltf/json_path.h"

namespace lightbatch::gltf {

/// Refuses, by name, required extensions that are neither understood nor safe to pass through.
Status check_required_extensions(const Json& json, const JsonPath& root,
                                 std::vector<std::string>& warnings);

/// Removes an extension from one object, and its "extensions" when that leaves it empty.
void erase_extension(Json& object, const char* name);

/// Removes a name from extensionsUsed and extensionsRequired, and the lists when they become empty.
void undeclare_extension(Json& json, const char* name);

}  // namespace lightbatch::gltf
