#pragma once

#include "core/gltf/document.h"
#include "core/gltf/json_path.h"
#include "core/gltf/load_buffers.h"

namespace lightbatch::gltf {

/// Fills document.images with encoded bytes; to be called when buffers are in plain form. An image
/// without data, or one with a forbidden uri that no texture uses, stays empty.
Status load_images(Document& document, const JsonPath& root, ResourceLoader& loader);

}  // namespace lightbatch::gltf
