#include "core/scene_in/nodes.h"

#include <array>
#include <charconv>
#include <string_view>

#include "core/gltf/accessor.h"
#include "core/gltf/fields.h"

namespace lightbatch::scene_in {
namespace {

using gltf::Json;
using gltf::kAbsent;

constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";

Affine local_transform(const Json& node) {
  if (const auto matrix = node.find("matrix"); matrix != node.end()) {
    return Affine::from_column_major(matrix->get<std::array<double, 16>>());
  }
  return trs_of(node).matrix();
}

bool hides(const Json& node) {
  const Json* visibility = gltf::extension_of(node, "KHR_node_visibility");
  if (visibility == nullptr) return false;
  const auto visible = visibility->find("visible");
  return visible != visibility->end() && *visible == false;
}

bool is_finite_transform(const Affine& m) {
  return is_finite(m.x) && is_finite(m.y) && is_finite(m.z) && is_finite(m.t);
}

/// Squashed to a line or a point: nothing below it has an area. A node squashed to a plane stays.
bool has_no_area(const Affine& m) {
  return length(cross(m.x, m.y)) == 0 && length(cross(m.y, m.z)) == 0 &&
         length(cross(m.z, m.x)) == 0;
}

std::optional<Moves> moves_of(std::string_view path) {
  if (path == "translation") return Moves::kTranslation;
  if (path == "rotation") return Moves::kRotation;
  if (path == "scale") return Moves::kScale;
  if (path.starts_with("weights") || path == "matrix") return Moves::kOther;
  return std::nullopt;
}

/// KHR_animation_pointer: "/nodes/3/translation" and the like.
std::optional<ChannelTarget> target_of_pointer(std::string_view pointer) {
  constexpr std::string_view kNodes = "/nodes/";
  if (!pointer.starts_with(kNodes)) return std::nullopt;
  pointer.remove_prefix(kNodes.size());
  std::uint32_t node = kAbsent;
  const auto parsed = std::from_chars(pointer.data(), pointer.data() + pointer.size(), node);
  if (parsed.ec != std::errc()) return std::nullopt;
  pointer.remove_prefix(static_cast<std::size_t>(parsed.ptr - pointer.data()));
  if (!pointer.starts_with('/')) return std::nullopt;
  const auto moves = moves_of(pointer.substr(1));
  if (!moves) return std::nullopt;
  return ChannelTarget{node, *moves};
}

std::vector<bool> find_animated(const Json& json) {
  std::vector<bool> animated(gltf::list_field(json, "nodes").size(), false);
  for (const Json& animation : gltf::list_field(json, "animations")) {
    for (const Json& channel : animation["channels"]) {
      if (const auto target = target_of(channel, animated.size())) animated[target->node] = true;
    }
  }
  return animated;
}

/// World transforms of all nodes, and for each whether an animation moves it.
Status transform_all(const gltf::Document& document, NodeTree& tree, std::vector<bool>& animated) {
  const Json& nodes = gltf::list_field(document.json, "nodes");
  std::vector<std::uint32_t>& parents = tree.parents;
  parents.assign(nodes.size(), kAbsent);
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    for (const Json& child : gltf::list_field(nodes[i], "children")) {
      parents[child.get<std::size_t>()] = i;
    }
  }
  std::vector<std::uint32_t> pending;
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    if (parents[i] == kAbsent) pending.push_back(i);
  }
  tree.local.resize(nodes.size());
  tree.world.resize(nodes.size());
  while (!pending.empty()) {
    const std::uint32_t node = pending.back();
    pending.pop_back();
    tree.order.push_back(node);
    tree.local[node] = local_transform(nodes[node]);
    Affine& world = tree.world[node];
    world = tree.local[node];
    if (parents[node] != kAbsent) {
      world = tree.world[parents[node]] * world;
      if (animated[parents[node]]) animated[node] = true;
    }
    if (!is_finite_transform(world)) {
      return malformed(document.name + "#/nodes/" + std::to_string(node),
                       "the node's world transform is not finite");
    }
    for (const Json& child : gltf::list_field(nodes[node], "children")) {
      pending.push_back(child.get<std::uint32_t>());
    }
  }
  return {};
}

}  // namespace

Trs trs_of(const Json& node) {
  Trs trs;
  if (const auto found = node.find("translation"); found != node.end()) {
    const auto t = found->get<std::array<double, 3>>();
    trs.translation = {t[0], t[1], t[2]};
  }
  if (const auto found = node.find("rotation"); found != node.end()) {
    trs.rotation = found->get<std::array<double, 4>>();
  }
  if (const auto found = node.find("scale"); found != node.end()) {
    const auto s = found->get<std::array<double, 3>>();
    trs.scale = {s[0], s[1], s[2]};
  }
  return trs;
}

std::optional<ChannelTarget> target_of(const Json& channel, std::size_t node_count) {
  const Json& target = channel["target"];
  std::optional<ChannelTarget> found;
  if (const auto moves = moves_of(target["path"].get_ref<const std::string&>())) {
    found = ChannelTarget{gltf::index_field(target, "node"), *moves};
  } else if (const Json* pointer = gltf::extension_of(target, "KHR_animation_pointer")) {
    const auto text = pointer->find("pointer");
    if (text != pointer->end() && text->is_string()) {
      found = target_of_pointer(text->get_ref<const std::string&>());
    }
  }
  if (found && found->node >= node_count) return std::nullopt;
  return found;
}

Result<NodeTree> read_nodes(const gltf::Document& document) {
  NodeTree tree;
  std::vector<bool> animated = find_animated(document.json);
  LB_RETURN_IF_ERROR(transform_all(document, tree, animated));

  const Json& scenes = gltf::list_field(document.json, "scenes");
  if (scenes.empty()) return tree;
  const Json& nodes = gltf::list_field(document.json, "nodes");
  const Json& scene = scenes[gltf::unsigned_field(document.json, "scene")];
  std::vector<PlacedNode> pending;
  const auto push_reversed = [&](const Json& list, bool hidden) {
    for (std::size_t i = list.size(); i-- > 0;) {
      const auto node = list[i].get<std::uint32_t>();
      pending.push_back({node, animated[node], hidden || hides(nodes[node])});
    }
  };
  push_reversed(gltf::list_field(scene, "nodes"), false);
  while (!pending.empty()) {
    const PlacedNode placed = pending.back();
    const std::uint32_t node = placed.node;
    pending.pop_back();
    if (has_no_area(tree.world[node])) {
      ++tree.zero_scale;
      continue;
    }
    tree.placed.push_back(placed);
    push_reversed(gltf::list_field(nodes[node], "children"), placed.hidden);
  }
  return tree;
}

std::uint64_t instance_count(const gltf::Document& document, std::uint32_t node) {
  const Json* extension = gltf::extension_of(document.json["nodes"][node], kInstancing);
  if (extension == nullptr) return 1;
  const Json& first = *(*extension)["attributes"].begin();
  return document.json["accessors"][first.get<std::size_t>()]["count"].get<std::uint64_t>();
}

Result<std::vector<Affine>> read_instances(const gltf::Document& document, std::uint32_t node) {
  std::vector<Affine> instances(instance_count(document, node));
  const Json* extension = gltf::extension_of(document.json["nodes"][node], kInstancing);
  if (extension == nullptr) return instances;
  const Json& attributes = (*extension)["attributes"];
  gltf::Values parts[3];
  const char* names[3] = {"TRANSLATION", "ROTATION", "SCALE"};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t accessor = gltf::index_field(attributes, names[i]);
    if (accessor == kAbsent) continue;
    LB_ASSIGN_OR_RETURN(parts[i], gltf::read_values(document, accessor));
  }
  const auto vector = [](const gltf::Values& values, std::size_t i, double fallback) -> Vec3d {
    if (values.data.empty()) return {fallback, fallback, fallback};
    const float* v = values.data.data() + 3 * i;
    return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
  };
  for (std::size_t i = 0; i < instances.size(); ++i) {
    std::array<double, 4> rotation = {0, 0, 0, 1};
    if (!parts[1].data.empty()) {
      for (std::size_t c = 0; c < 4; ++c) {
        rotation[c] = static_cast<double>(parts[1].data[4 * i + c]);
      }
    }
    instances[i] = Affine::from_trs(vector(parts[0], i, 0), rotation, vector(parts[2], i, 1));
  }
  return instances;
}

}  // namespace lightbatch::scene_in
