#pragma once

#include <cstdint>

#include "core/gltf/document.h"

namespace lightbatch::scene_out {

/// Names and notes that an earlier run left in the file, on what this one replaces: they would be
/// taken for those of this run.

/// Lightmap pages of the earlier run, in the notes of the scene; their numbers stay.
void rename_earlier_pages(gltf::Json& root, std::uint32_t scene_index);

/// Nodes of its batches and cells, below `count`, that have lost their mesh.
void clear_earlier_nodes(gltf::Json& root, std::uint32_t count);

}  // namespace lightbatch::scene_out
