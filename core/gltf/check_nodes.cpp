#include "core/gltf/check_nodes.h"

#include "core/gltf/fields.h"

namespace lightbatch::gltf {
namespace {

/// parents[i]: the node that lists i as its child, or kAbsent.
Status find_parents(const Json& nodes, const JsonPath& list, std::vector<std::uint32_t>& parents) {
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Json& children = list_field(nodes[i], "children");
    for (std::size_t k = 0; k < children.size(); ++k) {
      const auto child = children[k].get<std::size_t>();
      if (parents[child] != kAbsent) {
        return malformed(JsonPath(list, i).text() + "/children/" + std::to_string(k),
                         "node " + std::to_string(child) + " already has a parent, node " +
                             std::to_string(parents[child]));
      }
      parents[child] = static_cast<std::uint32_t>(i);
    }
  }
  return {};
}

/// With at most one parent each, nodes that no walk from a root reaches lie on a cycle (or below
/// it).
Status check_acyclic(const Json& nodes, const JsonPath& list,
                     const std::vector<std::uint32_t>& parents) {
  std::vector<std::uint32_t> pending;
  std::vector<bool> reached(nodes.size(), false);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (parents[i] == kAbsent) pending.push_back(static_cast<std::uint32_t>(i));
  }
  while (!pending.empty()) {
    const std::uint32_t node = pending.back();
    pending.pop_back();
    reached[node] = true;
    for (const Json& child : list_field(nodes[node], "children")) {
      pending.push_back(child.get<std::uint32_t>());
    }
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!reached[i]) {
      return malformed(JsonPath(list, i).text(), "the node is its own ancestor, or lies below one");
    }
  }
  return {};
}

Status check_node(const Json& json, const Json& node, const JsonPath& path,
                  std::vector<std::string>& warnings) {
  const bool decomposed =
      node.contains("translation") || node.contains("rotation") || node.contains("scale");
  if (node.contains("matrix")) {
    if (decomposed) {
      return malformed(path.text(), "has both a matrix and translation, rotation or scale");
    }
    const Json& matrix = node["matrix"];
    if (matrix[3] != 0 || matrix[7] != 0 || matrix[11] != 0 || matrix[15] != 1) {
      return malformed(path.text(), "the matrix is not affine: its last row must be 0 0 0 1");
    }
  }
  if (node.contains("skin") && !node.contains("mesh")) {
    warnings.push_back(path.text() + ": has a skin, but no mesh");
  }
  if (node.contains("weights") && node.contains("mesh")) {
    const Json& primitives = json["meshes"][node["mesh"].get<std::size_t>()]["primitives"];
    if (node["weights"].size() != list_field(primitives[0], "targets").size()) {
      return malformed(path.text(),
                       "has another number of weights than the mesh has morph targets");
    }
  }
  return {};
}

}  // namespace

Status check_nodes(const Json& json, const JsonPath& root, std::uint64_t max_nodes,
                   std::vector<std::string>& warnings) {
  const Json& nodes = list_field(json, "nodes");
  const JsonPath list(root, "nodes");
  if (nodes.size() > max_nodes) {
    return over_budget(list.text(), "the scene has " + std::to_string(nodes.size()) +
                                        " nodes; at most " + std::to_string(max_nodes) +
                                        " are allowed");
  }
  std::vector<std::uint32_t> parents(nodes.size(), kAbsent);
  LB_RETURN_IF_ERROR(find_parents(nodes, list, parents));
  LB_RETURN_IF_ERROR(check_acyclic(nodes, list, parents));
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    LB_RETURN_IF_ERROR(check_node(json, nodes[i], JsonPath(list, i), warnings));
  }
  const Json& scenes = list_field(json, "scenes");
  const JsonPath scene_list(root, "scenes");
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    for (const Json& node : list_field(scenes[s], "nodes")) {
      if (parents[node.get<std::size_t>()] == kAbsent) continue;
      return malformed(JsonPath(scene_list, s).text() + "/nodes",
                       "node " + node.dump() + " is not a root: it has a parent");
    }
  }
  return {};
}

}  // namespace lightbatch::gltf
