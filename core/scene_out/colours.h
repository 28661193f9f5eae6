#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/scene_out/mesh_builder.h"
#include "core/scene_out/writer.h"

namespace lightbatch::scene_out {

/// For every scene material, the one that stands for all that differ from it in nothing but name
/// and base colour factor; its own index where that is none. COLOR_0 multiplies the base colour
/// (glTF 3.9.2), so vertices can hold the factor. Those with a base colour texture differ in the
/// name alone. Materials with extras, or extensions that may read the base colour in another way,
/// stand for themselves; emitting ones, too, where light is `baked`: a relight may change each by
/// itself.
std::vector<std::uint32_t> material_classes(const Json& root, const scene::Scene& scene,
                                            bool baked);

/// Whether pieces of materials of one class need vertices to hold their base colours.
bool colours_differ(const Writer& writer, std::span<const batches::Piece> pieces);

/// COLOR_0 of rows: the base colour factor of each range's object. Bytes where these hold all
/// factors, floats otherwise.
CornerStream colour_stream(const Writer& writer, std::span<const IndexRange> ranges);

}  // namespace lightbatch::scene_out
