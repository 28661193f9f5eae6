#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/gltf/document.h"
#include "core/gltf/json_path.h"

namespace lightbatch::gltf {

/// Primitives of a document in plain form: attributes of fitting type and equal count, morph
/// targets likewise, texture coordinates for every texture of the material, index values below the
/// number of vertices. Indices are counted against max_triangles, each accessor's once.
Status check_meshes(const Document& document, const JsonPath& root, std::uint64_t max_triangles,
                    std::vector<std::string>& warnings);

/// Instance attributes of EXT_mesh_gpu_instancing: VEC3, VEC4, VEC3, of equal count.
Status check_instancing(const Document& document, const JsonPath& root);

}  // namespace lightbatch::gltf
