#pragma once

#include "core/base/bytes.h"
#include "core/gltf/document.h"

namespace lightbatch::scene_out {

/// EXT_meshopt_compression, lossless, of the vertex and index views of a packed file (one buffer):
/// returns the new buffer. Views that do not gain stay as they are, and those that extensions which
/// are not understood may name (`before`: the document as read).
Bytes compress_views(gltf::Json& root, const gltf::Json& before, Bytes binary);

}  // namespace lightbatch::scene_out
