#include "core/gltf/check_nodes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/gltf/fields.h"

namespace lightbatch::gltf {
namespace {

/// How far from unit length, or from a right angle, exporters' rounding may be.
constexpr double kUnitTolerance = 1e-2;

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

Status check_matrix(const Json& json, const JsonPath& path, std::vector<std::string>& warnings) {
  const auto m = json.get<std::array<double, 16>>();
  if (std::abs(m[3]) + std::abs(m[7]) + std::abs(m[11]) + std::abs(m[15] - 1) > 1e-5) {
    return malformed(path.text(), "the matrix is not affine: its last row must be 0 0 0 1");
  }
  // Columns that are not at right angles: a shear, which no translation, rotation and scale gives.
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t b = (a + 1) % 3;
    double product = 0, length_a = 0, length_b = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      product += m[4 * a + i] * m[4 * b + i];
      length_a += m[4 * a + i] * m[4 * a + i];
      length_b += m[4 * b + i] * m[4 * b + i];
    }
    if (std::abs(product) > kUnitTolerance * std::sqrt(length_a * length_b)) {
      warnings.push_back(path.text() + "/matrix: has a shear");
      break;
    }
  }
  return {};
}

/// Meshes with a primitive that no skin can move.
std::vector<bool> find_jointless(const Json& json) {
  std::vector<bool> jointless;
  for (const Json& mesh : list_field(json, "meshes")) {
    jointless.push_back(std::any_of(
        mesh["primitives"].begin(), mesh["primitives"].end(),
        [](const Json& primitive) { return !primitive["attributes"].contains("JOINTS_0"); }));
  }
  return jointless;
}

Status check_node(const Json& json, const Json& node, const std::vector<bool>& jointless,
                  const JsonPath& path, std::vector<std::string>& warnings) {
  const bool decomposed =
      node.contains("translation") || node.contains("rotation") || node.contains("scale");
  if (node.contains("matrix")) {
    if (decomposed) {
      return malformed(path.text(), "has both a matrix and translation, rotation or scale");
    }
    LB_RETURN_IF_ERROR(check_matrix(node["matrix"], path, warnings));
  }
  if (const auto rotation = node.find("rotation"); rotation != node.end()) {
    double norm = 0;
    for (const Json& part : *rotation) norm += part.get<double>() * part.get<double>();
    if (std::abs(norm - 1) > kUnitTolerance) {
      warnings.push_back(path.text() + "/rotation: is not of unit length; it is normalised");
    }
  }
  for (const char* name : {"skin", "weights"}) {
    if (node.contains(name) && !node.contains("mesh")) {
      return malformed(path.text(), std::string("has \"") + name + "\", but no mesh");
    }
  }
  if (node.contains("skin") && jointless[node["mesh"].get<std::size_t>()]) {
    return malformed(path.text(), "has a skin, but its mesh has no joints");
  }
  if (node.contains("weights")) {
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
  const std::vector<bool> jointless = find_jointless(json);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    LB_RETURN_IF_ERROR(check_node(json, nodes[i], jointless, JsonPath(list, i), warnings));
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
