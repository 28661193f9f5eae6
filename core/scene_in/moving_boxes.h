#pragma once

#include <vector>

#include "core/base/status.h"
#include "core/gltf/document.h"
#include "core/math/aabb.h"
#include "core/scene_in/nodes.h"

namespace lightbatch::scene_in {

/// A box that a node carries: a joint with the vertices that it moves, or a mesh under its node.
struct CarriedBox {
  std::uint32_t node = 0;
  Affine to_node;  // from the space of the box
  Aabbd box;
};

/// What one primitive that moves is made of, every morph target anywhere between weight 0 and 1: at
/// any moment it lies in the union of the boxes, as skinned vertices are weighted means of their
/// images under the joints. Empty without positions. `instances`: transforms under the node.
Result<std::vector<CarriedBox>> carried_boxes(const gltf::Document& document, std::uint32_t node,
                                              const gltf::Json& primitive,
                                              const std::vector<Affine>& instances);

/// World box of them all, nodes standing as `world` says.
Aabbd world_box(const std::vector<CarriedBox>& carried, const std::vector<Affine>& world);

}  // namespace lightbatch::scene_in
