#pragma once

#include "core/base/status.h"
#include "core/gltf/document.h"
#include "core/math/aabb.h"
#include "core/scene_in/nodes.h"

namespace lightbatch::scene_in {

/// World box of one primitive that moves, in its bind pose: skinned by the joints where they stand,
/// or under its node; morph targets at full weight included one by one. Empty without positions.
/// `instances`: transforms under the node.
Result<Aabbd> moving_box(const gltf::Document& document, const NodeTree& tree, std::uint32_t node,
                         const gltf::Json& primitive, const std::vector<Affine>& instances);

}  // namespace lightbatch::scene_in
