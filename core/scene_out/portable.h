#pragma once

#include <utility>
#include <vector>

#include "core/scene_out/mesh_builder.h"
#include "core/scene_out/writer.h"

namespace lightbatch::scene_out {

/// Objects with the scene triangles of each that are wanted.
using Pieces = std::vector<std::pair<std::uint32_t, std::vector<std::uint32_t>>>;

/// Light as colour: luminance of the surface, times the exposure, in COLOR_0 (normalised 16 bits)
/// of a mesh subdivided where light changes. The base colour texture stays with the material;
/// without one the colour holds everything, emission included. frame: origin of the mesh in the
/// world, or null for the object's own frame.
Result<std::vector<MeshData>> portable_meshes(Writer& writer, const Pieces& pieces,
                                              const Vec3d* frame, std::uint32_t max_vertices);

/// The unlit material that goes with portable_meshes.
std::uint32_t portable_material(Writer& writer, std::uint32_t scene_material);

/// Portable primitives of an object that stays in its node: the lit part, and the rest as it was.
Result<Json> portable_primitives(Writer& writer, std::uint32_t object);

}  // namespace lightbatch::scene_out
