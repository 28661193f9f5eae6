#pragma once

#include <cstdint>
#include <vector>

#include "core/gltf/document.h"
#include "core/gltf/json_path.h"
#include "core/gltf/load_buffers.h"

namespace lightbatch::gltf {

/// Decodes every primitive of KHR_draco_mesh_compression: its accessors get ordinary buffer views
/// in one new buffer, and the extension goes. INPUT_OVER_BUDGET beyond max_triangles. Adds
/// the accessors it filled to `decoded`. Call after check_buffer_views(), with buffers loaded.
Status decode_draco(Document& document, const JsonPath& root, std::uint64_t max_triangles,
                    ResourceLoader& loader, std::vector<std::uint32_t>& decoded);

}  // namespace lightbatch::gltf
