#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/status.h"
#include "core/gltf/document.h"
#include "core/math/mat.h"

namespace lightbatch::scene_in {

/// A node of the default scene.
struct PlacedNode {
  std::uint32_t node = 0;
  bool animated = false;  // itself or an ancestor is the target of an animation
  bool hidden = false;    // by KHR_node_visibility, its own or an ancestor's
};

/// A node's own transform in parts.
struct Trs {
  Vec3d translation{0, 0, 0};
  std::array<double, 4> rotation{0, 0, 0, 1};
  Vec3d scale{1, 1, 1};
  Affine matrix() const { return Affine::from_trs(translation, rotation, scale); }
};
/// Of a node that has no matrix.
Trs trs_of(const gltf::Json& node);

/// What an animation channel moves; none when it moves no node (KHR_animation_pointer counts).
enum class Moves : std::uint8_t { kTranslation, kRotation, kScale, kOther };
struct ChannelTarget {
  std::uint32_t node = 0;
  Moves moves = Moves::kOther;
};
std::optional<ChannelTarget> target_of(const gltf::Json& channel, std::size_t node_count);

struct NodeTree {
  std::vector<std::uint32_t> parents;  // of every node of the file; gltf::kAbsent: none
  std::vector<std::uint32_t> order;    // all nodes, parents before children
  std::vector<Affine> local;           // of every node
  std::vector<Affine> world;           // of every node of the file, in double
  std::vector<PlacedNode> placed;      // of the default scene, parents before children
  std::uint64_t zero_scale = 0;        // nodes left out, with all below them
};

/// Walks the hierarchy without recursion. INPUT_MALFORMED when a transform is not finite.
Result<NodeTree> read_nodes(const gltf::Document& document);

/// Object-to-node transforms of EXT_mesh_gpu_instancing; one identity when the node has none.
Result<std::vector<Affine>> read_instances(const gltf::Document& document, std::uint32_t node);
/// Number of them, without reading any.
std::uint64_t instance_count(const gltf::Document& document, std::uint32_t node);

}  // namespace lightbatch::scene_in
