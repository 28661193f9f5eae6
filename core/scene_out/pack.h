#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/bytes.h"
#include "core/gltf/document.h"

namespace lightbatch::scene_out {

/// Drops meshes that no node draws any more and renumbers the others. `before` is the document as
/// read: what it held unused stays, here and in pack().
void drop_meshes(gltf::Json& root, const gltf::Json& before);

/// Drops accessors that lost their use with their meshes and buffer views that nothing reads,
/// renumbers what is left, and puts all bytes into one buffer. Call after drop_meshes().
///
/// Extensions that are not understood may hold numbers of meshes, accessors or views. Such numbers
/// pin what they could mean, and then nothing of that kind is renumbered: new entries take the
/// places of dropped ones.
///
/// buffers: those of the document, then the new ones; views of `root` refer to them.
Bytes pack(gltf::Json& root, const gltf::Json& before, std::span<const Bytes* const> buffers);

}  // namespace lightbatch::scene_out
