#pragma once

#include <cstdint>
#include <vector>

#include "core/base/status.h"
#include "core/gltf/document.h"
#include "core/math/mat.h"

namespace lightbatch::scene_in {

/// A node of the default scene.
struct PlacedNode {
  std::uint32_t node = 0;
  bool animated = false;  // itself or an ancestor is the target of an animation
};

struct NodeTree {
  std::vector<Affine> world;       // of every node of the file, in double
  std::vector<PlacedNode> placed;  // of the default scene, parents before children
  std::uint64_t zero_scale = 0;    // nodes left out, with all below them
};

/// Walks the hierarchy without recursion. INPUT_MALFORMED when a transform is not finite.
Result<NodeTree> read_nodes(const gltf::Document& document);

/// Object-to-node transforms of EXT_mesh_gpu_instancing; one identity when the node has none.
Result<std::vector<Affine>> read_instances(const gltf::Document& document, std::uint32_t node);
/// Number of them, without reading any.
std::uint64_t instance_count(const gltf::Document& document, std::uint32_t node);

}  // namespace lightbatch::scene_in
