#pragma once

#include <cstdint>
#include <functional>
#include <set>

#include "core/gltf/document.h"

namespace lightbatch::scene_out {

/// Calls visit(slot) for every place of core glTF, and of EXT_mesh_gpu_instancing, that holds the
/// number of an accessor (outside meshes).
void for_each_accessor_outside_meshes(gltf::Json& root,
                                      const std::function<void(gltf::Json& slot)>& visit);
/// The same for one mesh.
void for_each_accessor_of_mesh(gltf::Json& mesh,
                               const std::function<void(gltf::Json& slot)>& visit);

/// Numbers inside extensions that are not understood, by what they could mean, and what JSON
/// pointers inside them name ("/nodes/3/translation").
struct Pins {
  std::set<std::uint32_t> meshes, accessors, views;
  std::set<std::uint32_t> nodes;  // by pointers
  bool any_node = false;          // "/nodes/{index}/translation": known only when it is used
  bool materials = false;         // of any number
};
Pins find_pins(const gltf::Json& root);

}  // namespace lightbatch::scene_out
