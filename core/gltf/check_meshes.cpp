#include "core/gltf/check_meshes.h"

#include <map>
#include <optional>
#include <string_view>

#include "core/gltf/attribute_formats.h"
#include "core/gltf/elements.h"
#include "core/gltf/fields.h"
#include "core/gltf/layout.h"
#include "core/gltf/texture_slots.h"

namespace lightbatch::gltf {
namespace {

class MeshCheck {
 public:
  MeshCheck(const Document& document, std::uint64_t max_triangles,
            std::vector<std::string>& warnings)
      : document_(document),
        json_(document.json),
        accessors_(list_field(json_, "accessors")),
        slots_(texture_coordinates_needed(json_)),
        indices_left_(3 * max_triangles),
        warnings_(warnings) {
    for (const Json& name : list_field(json_, "extensionsUsed")) {
      if (name == "KHR_mesh_quantization") quantized_ = true;
    }
  }

  std::uint64_t unbounded() const { return unbounded_; }

  Status check_mesh(const Json& mesh, const JsonPath& path) {
    const Json& primitives = mesh["primitives"];
    const JsonPath list(path, "primitives");
    const std::size_t targets = list_field(primitives[0], "targets").size();
    for (std::size_t i = 0; i < primitives.size(); ++i) {
      const JsonPath here(list, i);
      LB_RETURN_IF_ERROR(check_primitive(primitives[i], here));
      if (list_field(primitives[i], "targets").size() != targets) {
        return malformed(here.text(), "the primitives of a mesh differ in their morph targets");
      }
    }
    if (mesh.contains("weights") && mesh["weights"].size() != targets) {
      return malformed(path.text(), "has another number of weights than morph targets");
    }
    return {};
  }

 private:
  /// Type and count of one attribute; *count is set by the first and compared by the others.
  Status check_attribute(const std::string& name, std::uint32_t accessor, bool target,
                         const JsonPath& path, std::optional<std::uint64_t>& count) {
    const std::optional<Layout> layout = layout_of(accessors_[accessor]);
    if (!layout) return malformed(path.text(), "the accessor has an unknown type");
    if (count && *count != layout->count) {
      return malformed(path.text(), "has " + std::to_string(layout->count) +
                                        " elements, other attributes " + std::to_string(*count));
    }
    count = layout->count;
    LB_RETURN_IF_ERROR(check_data(document_, accessor, path));
    switch (check_attribute_format(name, *layout, target, quantized_)) {
      case AttributeFault::kNone:
        return {};
      case AttributeFault::kUnknownName:
        warnings_.push_back(path.text() + ": unknown attribute");
        return {};
      case AttributeFault::kWrongType:
        return malformed(path.text(), "the accessor has the wrong type");
      case AttributeFault::kWrongComponents:
        return malformed(path.text(), "the accessor has the wrong component type");
      case AttributeFault::kNeedsQuantization:
        break;
    }
    return malformed(path.text(),
                     "the component type needs KHR_mesh_quantization, which is not listed as used");
  }

  Status check_primitive(const Json& primitive, const JsonPath& path) {
    const Json& attributes = primitive["attributes"];
    const JsonPath attribute_path(path, "attributes");
    std::optional<std::uint64_t> count;
    // POSITION first: the others are compared with it.
    if (const auto position = attributes.find("POSITION"); position != attributes.end()) {
      LB_RETURN_IF_ERROR(check_attribute("POSITION", position->get<std::uint32_t>(), false,
                                         JsonPath(attribute_path, "POSITION"), count));
      const Json& accessor = accessors_[position->get<std::size_t>()];
      if (!accessor.contains("min") || !accessor.contains("max")) ++unbounded_;
    } else {
      warnings_.push_back(path.text() + ": has no POSITION; nothing is drawn");
    }
    for (const auto& [name, accessor] : attributes.items()) {
      LB_RETURN_IF_ERROR(check_attribute(name, accessor.get<std::uint32_t>(), false,
                                         JsonPath(attribute_path, name), count));
    }
    LB_RETURN_IF_ERROR(check_targets(primitive, path, count));
    LB_RETURN_IF_ERROR(check_sets(attributes, attribute_path));
    LB_RETURN_IF_ERROR(check_indices(primitive, path, *count));
    check_corners(primitive, path, *count);
    const std::uint32_t material = index_field(primitive, "material");
    if (material == kAbsent) return {};
    for (const std::uint32_t set : slots_[material]) {
      const std::string name = "TEXCOORD_" + std::to_string(set);
      if (attributes.contains(name)) continue;
      return malformed(path.text(), "material " + std::to_string(material) + " has a texture on " +
                                        name + ", which the primitive lacks");
    }
    return {};
  }

  /// Corners that make up no whole line or triangle are drawn by nobody.
  void check_corners(const Json& primitive, const JsonPath& path, std::uint64_t vertices) {
    const std::uint32_t accessor = index_field(primitive, "indices");
    const std::uint64_t corners =
        accessor == kAbsent ? vertices : unsigned_field(accessors_[accessor], "count");
    const std::uint64_t mode = unsigned_field(primitive, "mode", 4);
    const bool whole = mode == 0   ? true
                       : mode == 1 ? corners % 2 == 0
                       : mode == 4 ? corners % 3 == 0
                                   : corners >= (mode < 4 ? 2u : 3u);
    if (whole) return;
    warnings_.push_back(path.text() + ": " + std::to_string(corners) +
                        " corners do not fit its mode; what is over is not drawn");
  }

  Status check_targets(const Json& primitive, const JsonPath& path,
                       std::optional<std::uint64_t>& count) {
    const JsonPath list(path, "targets");
    const Json& targets = list_field(primitive, "targets");
    for (std::size_t i = 0; i < targets.size(); ++i) {
      const JsonPath target(list, i);
      for (const auto& [name, accessor] : targets[i].items()) {
        if (!primitive["attributes"].contains(name)) {
          return malformed(JsonPath(target, name).text(), "the primitive has no such attribute");
        }
        LB_RETURN_IF_ERROR(check_attribute(name, accessor.get<std::uint32_t>(), true,
                                           JsonPath(target, name), count));
      }
    }
    return {};
  }

  /// Numbered attributes: JOINTS_n and WEIGHTS_n come in pairs; sets without gaps are only asked
  /// for.
  Status check_sets(const Json& attributes, const JsonPath& path) {
    for (const auto& [name, accessor] : attributes.items()) {
      const std::size_t underscore = name.rfind('_');
      if (underscore == std::string::npos || underscore == 0) continue;
      const std::string kind = name.substr(0, underscore);
      const std::string number = name.substr(underscore + 1);
      if ((kind == "JOINTS" && !attributes.contains("WEIGHTS_" + number)) ||
          (kind == "WEIGHTS" && !attributes.contains("JOINTS_" + number))) {
        return malformed(JsonPath(path, name).text(), "joints and weights come in pairs");
      }
      if (number == "1" && (kind == "TEXCOORD" || kind == "COLOR" || kind == "JOINTS") &&
          !attributes.contains(kind + "_0")) {
        warnings_.push_back(JsonPath(path, name).text() + ": there is no set 0 before it");
      }
    }
    return {};
  }

  Status check_indices(const Json& primitive, const JsonPath& path, std::uint64_t vertices) {
    const std::uint32_t accessor = index_field(primitive, "indices");
    if (accessor == kAbsent) return {};
    const JsonPath here(path, "indices");
    const std::optional<Layout> layout = layout_of(accessors_[accessor]);
    if (!layout || !is_index_layout(*layout) || layout->normalized) {
      return malformed(here.text(), "the accessor is not of unsigned scalars");
    }
    LB_RETURN_IF_ERROR(check_data(document_, accessor, here));
    const std::uint32_t view = index_field(accessors_[accessor], "bufferView");
    if (view != kAbsent && json_["bufferViews"][view].contains("byteStride")) {
      return malformed(here.text(), "indices lie in a bufferView with a byteStride");
    }
    const auto [known, added] = largest_.try_emplace(accessor, 0);
    if (added) {
      if (layout->count > indices_left_) {
        return over_budget(here.text(), "the scene has too many indices");
      }
      indices_left_ -= layout->count;
      known->second = largest_index(document_, accessor);
    }
    const std::uint32_t largest = known->second;
    if (largest >= vertices) {
      return malformed(here.text(), "index " + std::to_string(largest) +
                                        " is out of range: the primitive has " +
                                        std::to_string(vertices) + " vertices");
    }
    return {};
  }

  const Document& document_;
  const Json& json_;
  const Json& accessors_;
  std::vector<std::vector<std::uint32_t>> slots_;   // per material: sets of texture coordinates
  std::map<std::uint32_t, std::uint32_t> largest_;  // index value of each accessor of indices
  std::uint64_t indices_left_;
  std::vector<std::string>& warnings_;
  bool quantized_ = false;
  std::uint64_t unbounded_ = 0;  // primitives whose positions have no min and max
};

}  // namespace

Status check_meshes(const Document& document, const JsonPath& root, std::uint64_t max_triangles,
                    std::vector<std::string>& warnings) {
  const Json& meshes = list_field(document.json, "meshes");
  const JsonPath list(root, "meshes");
  MeshCheck check(document, max_triangles, warnings);
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    LB_RETURN_IF_ERROR(check.check_mesh(meshes[i], JsonPath(list, i)));
  }
  if (check.unbounded() > 0) {
    warnings.push_back(list.text() + ": positions without min and max in " +
                       std::to_string(check.unbounded()) + " primitives");
  }
  return {};
}

Status check_instancing(const Document& document, const JsonPath& root) {
  const Json& json = document.json;
  const Json& nodes = list_field(json, "nodes");
  const JsonPath list(root, "nodes");
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Json* extension = extension_of(nodes[i], "EXT_mesh_gpu_instancing");
    if (extension == nullptr) continue;
    const std::string place = JsonPath(list, i).text() + "/extensions/EXT_mesh_gpu_instancing";
    std::optional<std::uint64_t> count;
    for (const auto& [name, accessor] : (*extension)["attributes"].items()) {
      const auto index = accessor.get<std::uint32_t>();
      LB_RETURN_IF_ERROR(check_data(document, index, JsonPath(list, i)));
      const std::optional<Layout> layout = layout_of(json["accessors"][index]);
      if (!layout) return malformed(place, "the accessor of " + name + " has an unknown type");
      if (count && *count != layout->count) {
        return malformed(place, "the instance attributes differ in count");
      }
      count = layout->count;
      const std::uint32_t expected = name == "ROTATION" ? 4 : 3;
      const bool transform = name == "TRANSLATION" || name == "ROTATION" || name == "SCALE";
      if (transform && layout->components != expected) {
        return malformed(place, name + " has the wrong type");
      }
    }
  }
  return {};
}

}  // namespace lightbatch::gltf
