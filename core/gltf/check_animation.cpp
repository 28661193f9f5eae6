#include "core/gltf/check_animation.h"

#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "core/gltf/accessor.h"
#include "core/gltf/elements.h"

namespace lightbatch::gltf {
namespace {

constexpr std::uint32_t kFloat = 5126;

bool has_stride(const Json& json, std::uint32_t accessor) {
  const std::uint32_t view = index_field(json["accessors"][accessor], "bufferView");
  return view != kAbsent && json["bufferViews"][view].contains("byteStride");
}

/// Rotations and weights may be normalised integers (glTF 3.11), nothing else may.
bool has_right_type(std::string_view path, const Layout& layout) {
  const bool small = layout.normalized && layout.component_bytes <= 2;
  const bool is_float = layout.component_type == kFloat;
  if (path == "rotation") return layout.components == 4 && layout.rows == 4 && (is_float || small);
  if (path == "weights") return layout.components == 1 && (is_float || small);
  return layout.components == 3 && is_float;
}

class AnimationCheck {
 public:
  AnimationCheck(const Document& document, std::vector<std::string>& warnings)
      : document_(document), json_(document.json), warnings_(warnings) {}

  Status check(const Json& animation, const JsonPath& path) {
    const Json& samplers = animation["samplers"];
    const JsonPath sampler_list(path, "samplers");
    for (std::size_t s = 0; s < samplers.size(); ++s) {
      LB_RETURN_IF_ERROR(check_sampler(samplers[s], JsonPath(sampler_list, s)));
    }
    const Json& channels = animation["channels"];
    const JsonPath channel_list(path, "channels");
    std::set<std::pair<std::uint32_t, std::string>> targets;
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const JsonPath here(channel_list, c);
      const Json& target = channels[c]["target"];
      LB_RETURN_IF_ERROR(check_channel(channels[c], samplers, here));
      const std::uint32_t node = index_field(target, "node");
      if (node != kAbsent && !targets.emplace(node, text_field(target, "path")).second) {
        return malformed(here.text(), "the same property of node " + std::to_string(node) +
                                          " is animated twice");
      }
    }
    return {};
  }

 private:
  Status check_sampler(const Json& sampler, const JsonPath& path) {
    const std::uint32_t input = index_field(sampler, "input");
    for (const char* name : {"input", "output"}) {
      const std::uint32_t accessor = index_field(sampler, name);
      LB_RETURN_IF_ERROR(check_data(document_, accessor, path));
      if (!layout_of(json_["accessors"][accessor])) {
        return malformed(path.text(), "an accessor has an unknown type");
      }
      if (has_stride(json_, accessor)) {
        return malformed(path.text(), "animation data lies in a bufferView with a byteStride");
      }
    }
    const Layout times = *layout_of(json_["accessors"][input]);
    if (times.components != 1 || times.component_type != kFloat) {
      return malformed(path.text(), "the input of an animation sampler must be float scalars");
    }
    const std::string interpolation = text_field(sampler, "interpolation", "LINEAR");
    if (interpolation == "CUBICSPLINE" && times.count < 2) {
      return malformed(path.text(), "CUBICSPLINE needs at least two key frames");
    }
    if (interpolation != "LINEAR" && interpolation != "STEP" && interpolation != "CUBICSPLINE") {
      warnings_.push_back(path.text() + ": unknown interpolation");
    }
    LB_RETURN_IF_ERROR(check_times(input, path));
    if (!json_["accessors"][input].contains("min") || !json_["accessors"][input].contains("max")) {
      warnings_.push_back(path.text() + ": the input accessor has no min and max");
    }
    return {};
  }

  /// Key frames ascend from zero on; each accessor is looked at once.
  Status check_times(std::uint32_t accessor, const JsonPath& path) {
    if (!times_checked_.insert(accessor).second) return {};
    LB_ASSIGN_OR_RETURN(const Values times, read_values(document_, accessor));
    float last = -1;
    for (const float time : times.data) {
      if (time < 0 || time <= last) {
        warnings_.push_back(path.text() + ": the times of the key frames do not ascend");
        return {};
      }
      last = time;
    }
    return {};
  }

  Status check_channel(const Json& channel, const Json& samplers, const JsonPath& path) {
    const std::uint64_t sampler = unsigned_field(channel, "sampler");
    if (sampler >= samplers.size()) {
      return malformed(path.text() + "/sampler",
                       "index " + std::to_string(sampler) + " is out of range");
    }
    const Json& target = channel["target"];
    const std::string property = text_field(target, "path");
    const std::uint32_t node = index_field(target, "node");
    const bool transform =
        property == "translation" || property == "rotation" || property == "scale";
    if (!transform && property != "weights") {
      if (property != "pointer") warnings_.push_back(path.text() + ": unknown target path");
      return {};
    }
    if (node == kAbsent) return {};  // glTF 3.11: such a channel is ignored
    if (transform && json_["nodes"][node].contains("matrix")) {
      return malformed(path.text(), "animates a node whose transform is a matrix");
    }
    std::uint64_t values_per_key = 1;
    if (!transform) {
      values_per_key = morph_targets(node);
      if (values_per_key == 0) return malformed(path.text(), "the node has no morph targets");
    }
    return check_output(samplers[sampler], property, values_per_key, path);
  }

  std::uint64_t morph_targets(std::uint32_t node) const {
    const std::uint32_t mesh = index_field(json_["nodes"][node], "mesh");
    if (mesh == kAbsent) return 0;
    return list_field(json_["meshes"][mesh]["primitives"][0], "targets").size();
  }

  Status check_output(const Json& sampler, const std::string& property,
                      std::uint64_t values_per_key, const JsonPath& path) const {
    const Layout times = *layout_of(json_["accessors"][index_field(sampler, "input")]);
    const Layout values = *layout_of(json_["accessors"][index_field(sampler, "output")]);
    if (!has_right_type(property, values)) {
      return malformed(path.text(), "the sampler's output does not fit " + property);
    }
    const bool cubic = text_field(sampler, "interpolation") == "CUBICSPLINE";
    const std::uint64_t per_key = values_per_key * (cubic ? 3 : 1);
    if (values.count / per_key != times.count || values.count % per_key != 0) {
      return malformed(path.text(), "has " + std::to_string(values.count) + " output values for " +
                                        std::to_string(times.count) + " key frames");
    }
    return {};
  }

  const Document& document_;
  const Json& json_;
  std::vector<std::string>& warnings_;
  std::set<std::uint32_t> times_checked_;
};

}  // namespace

Status check_animations(const Document& document, const JsonPath& root,
                        std::vector<std::string>& warnings) {
  const Json& animations = list_field(document.json, "animations");
  const JsonPath list(root, "animations");
  AnimationCheck check(document, warnings);
  for (std::size_t i = 0; i < animations.size(); ++i) {
    LB_RETURN_IF_ERROR(check.check(animations[i], JsonPath(list, i)));
  }
  return {};
}

}  // namespace lightbatch::gltf
