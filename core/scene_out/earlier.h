#pragma once

#include <cstdint>
#include <vector>

#include "core/scene_out/writer.h"

namespace lightbatch::scene_out {

/// Names and notes that an earlier run left in the file, on what this one replaces: they would be
/// taken for those of this run.

/// Lightmap pages of the earlier run, in the notes of the scene; their numbers stay. Returns them.
std::vector<std::uint32_t> rename_earlier_pages(gltf::Json& root, std::uint32_t scene_index);

/// Puts a picture of one texel into the place of those pages that nothing shows any more.
void empty_earlier_pages(Writer& w, const std::vector<std::uint32_t>& images);

/// Nodes of its batches and cells, below `count`, that have lost their mesh.
void clear_earlier_nodes(gltf::Json& root, std::uint32_t count);

}  // namespace lightbatch::scene_out
