#pragma once

#include "core/scene_out/mesh_builder.h"
#include "core/scene_out/writer.h"

namespace lightbatch::scene_out {

/// Where a run of indices of a new primitive came from, for extras: the primitive of the source
/// mesh, its extras, and its material where vertices hold the colours of several.
Json range_json(const Writer& w, std::size_t primitive, const IndexRange& range, bool coloured);

}  // namespace lightbatch::scene_out
