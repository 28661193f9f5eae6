#pragma once

#include "core/gltf/document.h"
#include "core/gltf/json_path.h"
#include "core/gltf/load_buffers.h"

namespace lightbatch::gltf {

/// Decodes every bufferView of EXT_meshopt_compression into one new buffer, points the view there
/// and removes the extension; then drops the fallback buffers that no view needs any more. Sizes
/// come from the JSON and are held against the compressed bytes before anything is allocated. Call
/// after load_buffers() and check_buffer_views().
Status decode_meshopt(Document& document, const JsonPath& root, ResourceLoader& loader);

}  // namespace lightbatch::gltf
