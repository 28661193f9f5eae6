#pragma once

#include "core/base/bytes.h"
#include "core/base/status.h"
#include "core/gltf/document.h"

namespace lightbatch::scene_out {

/// KHR_draco_mesh_compression of the indexed triangles of a packed file (one buffer): returns the
/// new buffer. Triangles and vertices get an order of their own; triangles of a range that
/// extras.lightbatch names stay together, and the range says where they are.
/// Lossy: float positions are rounded to a grid that all meshes share (a power of two, 1/16384 of
/// the median mesh's size), so meshes that met still meet; those far smaller have steps of 1/2048
/// of their own size; normals to 12 bits; texture
/// coordinates to 1/65536. Everything else is exact. Primitives with morph targets stay as
/// they are. What extensions that are not understood may name stays beside the streams. Same
/// bytes on any number of threads.
Result<Bytes> compress_draco(gltf::Json& root, Bytes binary);

}  // namespace lightbatch::scene_out
