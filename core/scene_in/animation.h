#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/gltf/document.h"
#include "core/scene_in/nodes.h"

namespace lightbatch::scene_in {

/// Calls visit(world transforms of every node) for moments of every animation of the file: its key
/// frames and moments between them, about 250 of them at most, evenly chosen. Each animation plays
/// alone, as glTF leaves their mixing open; nodes that it does not move stand as the file has them.
///
/// Work is bounded, a visit counting as `visit_cost` node transforms: what a file asks for beyond
/// the bound is left out with a warning. INPUT_MALFORMED when a value is not finite.
Status for_each_pose(const gltf::Document& document, const NodeTree& tree, std::size_t visit_cost,
                     const std::function<void(const std::vector<Affine>& world)>& visit,
                     std::vector<std::string>& warnings);

}  // namespace lightbatch::scene_in
