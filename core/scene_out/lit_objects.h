#pragma once

#include <map>
#include <vector>

#include "core/scene_out/writer.h"

namespace lightbatch::scene_out {

/// Primitives with lightmaps for objects of one source primitive that stay in their nodes: vertices
/// are split where TEXCOORD_1 of any of them needs it, so that all share every other accessor.
/// One list of glTF primitives (one for each page, and one for triangles without) per object.
Result<std::vector<Json>> lit_primitives(Writer& writer, const std::vector<std::uint32_t>& objects);

}  // namespace lightbatch::scene_out
