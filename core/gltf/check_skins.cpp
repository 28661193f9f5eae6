#include "core/gltf/check_skins.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "core/gltf/elements.h"

namespace lightbatch::gltf {
namespace {

constexpr std::uint32_t kFloat = 5126;

/// Order of entering and leaving each node in a walk of the forest: a is above (or is) b exactly
/// when a's interval holds b's entry.
class Forest {
 public:
  explicit Forest(const Json& nodes)
      : first_(nodes.size(), 0), last_(nodes.size(), 0), root_(nodes.size(), 0) {
    std::vector<bool> is_child(nodes.size(), false);
    for (const Json& node : nodes) {
      for (const Json& child : list_field(node, "children")) {
        is_child[child.get<std::size_t>()] = true;
      }
    }
    std::uint32_t clock = 0;
    for (std::uint32_t i = 0; i < nodes.size(); ++i) {
      if (!is_child[i]) walk(nodes, i, clock);
    }
  }

  bool is_above(std::uint32_t upper, std::uint32_t lower) const {
    return first_[upper] <= first_[lower] && first_[lower] <= last_[upper];
  }
  std::uint32_t root_of(std::uint32_t node) const { return root_[node]; }

 private:
  void walk(const Json& nodes, std::uint32_t root, std::uint32_t& clock) {
    struct Step {
      std::uint32_t node;
      bool leaving;
    };
    std::vector<Step> pending = {{root, false}};
    while (!pending.empty()) {
      const Step step = pending.back();
      pending.pop_back();
      if (step.leaving) {
        last_[step.node] = clock - 1;
        continue;
      }
      first_[step.node] = clock++;
      root_[step.node] = root;
      pending.push_back({step.node, true});
      for (const Json& child : list_field(nodes[step.node], "children")) {
        pending.push_back({child.get<std::uint32_t>(), false});
      }
    }
  }

  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> last_;
  std::vector<std::uint32_t> root_;
};

Status check_bind_matrices(const Document& document, const Json& skin, const JsonPath& path) {
  const std::uint32_t accessor = index_field(skin, "inverseBindMatrices");
  if (accessor == kAbsent) return {};
  const JsonPath here(path, "inverseBindMatrices");
  LB_RETURN_IF_ERROR(check_data(document, accessor, here));
  const Json& json = document.json["accessors"][accessor];
  const std::optional<Layout> layout = layout_of(json);
  if (!layout || layout->components != 16 || layout->component_type != kFloat ||
      layout->count < skin["joints"].size()) {
    return malformed(here.text(), "must be a float matrix for each joint");
  }
  const std::uint32_t view = index_field(json, "bufferView");
  if (view != kAbsent && document.json["bufferViews"][view].contains("byteStride")) {
    return malformed(here.text(), "lies in a bufferView with a byteStride");
  }
  return {};
}

}  // namespace

Status check_skins(const Document& document, const JsonPath& root,
                   std::vector<std::string>& warnings) {
  const Json& skins = list_field(document.json, "skins");
  if (skins.empty()) return {};
  const Forest forest(list_field(document.json, "nodes"));
  const JsonPath list(root, "skins");
  for (std::size_t i = 0; i < skins.size(); ++i) {
    const JsonPath path(list, i);
    const Json& joints = skins[i]["joints"];
    LB_RETURN_IF_ERROR(check_bind_matrices(document, skins[i], path));
    const std::uint32_t skeleton = index_field(skins[i], "skeleton");
    const std::uint32_t first = forest.root_of(joints[0].get<std::uint32_t>());
    if (std::any_of(joints.begin(), joints.end(), [&](const Json& joint) {
          return forest.root_of(joint.get<std::uint32_t>()) != first;
        })) {
      // Viewers place joints one by one: the trees that they are in do not matter to them.
      warnings.push_back(path.text() + ": the joints have no common root");
      continue;
    }
    for (const Json& joint : joints) {
      const auto node = joint.get<std::uint32_t>();
      if (skeleton != kAbsent && !forest.is_above(skeleton, node)) {
        return malformed(path.text(), "the skeleton node is not above joint node " + joint.dump());
      }
    }
  }
  return {};
}

}  // namespace lightbatch::gltf
