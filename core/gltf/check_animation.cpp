#include "core/gltf/check_animation.h"

#include <optional>

#include "core/gltf/elements.h"

namespace lightbatch::gltf {
namespace {

constexpr std::uint32_t kFloat = 5126;

Status check_animation_sampler(const Document& document, const Json& sampler,
                               const JsonPath& path) {
  for (const char* name : {"input", "output"}) {
    LB_RETURN_IF_ERROR(check_data(document, index_field(sampler, name), path));
  }
  const Json& accessors = document.json["accessors"];
  const std::optional<Layout> input = layout_of(accessors[index_field(sampler, "input")]);
  const std::optional<Layout> output = layout_of(accessors[index_field(sampler, "output")]);
  if (!input || !output) return malformed(path.text(), "an accessor has an unknown type");
  if (input->components != 1 || input->component_type != kFloat) {
    return malformed(path.text(), "the input of an animation sampler must be float scalars");
  }
  const bool cubic = text_field(sampler, "interpolation") == "CUBICSPLINE";
  if (output->count % input->count != 0 || (cubic && output->count % (3 * input->count) != 0)) {
    return malformed(path.text(), "has " + std::to_string(output->count) + " output values for " +
                                      std::to_string(input->count) + " key frames");
  }
  return {};
}

}  // namespace

Status check_animations(const Document& document, const JsonPath& root) {
  const Json& animations = list_field(document.json, "animations");
  const JsonPath list(root, "animations");
  for (std::size_t i = 0; i < animations.size(); ++i) {
    const JsonPath path(list, i);
    const Json& samplers = animations[i]["samplers"];
    const JsonPath sampler_list(path, "samplers");
    for (std::size_t s = 0; s < samplers.size(); ++s) {
      LB_RETURN_IF_ERROR(check_animation_sampler(document, samplers[s], JsonPath(sampler_list, s)));
    }
    const Json& channels = animations[i]["channels"];
    const JsonPath channel_list(path, "channels");
    for (std::size_t c = 0; c < channels.size(); ++c) {
      if (channels[c]["sampler"].get<std::uint64_t>() >= samplers.size()) {
        return malformed(JsonPath(channel_list, c).text() + "/sampler",
                         "the index is out of range");
      }
    }
  }
  return {};
}

Status check_skins(const Document& document, const JsonPath& root) {
  const Json& skins = list_field(document.json, "skins");
  const JsonPath list(root, "skins");
  for (std::size_t i = 0; i < skins.size(); ++i) {
    const std::uint32_t accessor = index_field(skins[i], "inverseBindMatrices");
    if (accessor == kAbsent) continue;
    LB_RETURN_IF_ERROR(check_data(document, accessor, JsonPath(list, i)));
    const std::optional<Layout> layout = layout_of(document.json["accessors"][accessor]);
    if (!layout || layout->components != 16 || layout->component_type != kFloat ||
        layout->count < skins[i]["joints"].size()) {
      return malformed(JsonPath(list, i).text() + "/inverseBindMatrices",
                       "must be a float matrix for each joint");
    }
  }
  return {};
}

}  // namespace lightbatch::gltf
