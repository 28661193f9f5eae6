#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/gltf/document.h"
#include "core/gltf/json_path.h"

namespace lightbatch::gltf {

/// The node hierarchy is a set of disjoint strict trees (glTF 3.5.2): no node has two parents, none
/// is its own ancestor, scenes name roots only. Works without recursion, for chains of any depth.
Status check_nodes(const Json& json, const JsonPath& root, std::uint64_t max_nodes,
                   std::vector<std::string>& warnings);

}  // namespace lightbatch::gltf
