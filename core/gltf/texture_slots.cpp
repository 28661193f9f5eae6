#include "core/gltf/texture_slots.h"

#include <algorithm>

#include "core/gltf/fields.h"

namespace lightbatch::gltf {
namespace {

/// Adds the set of every "...Texture" slot of one object (material, or a part of it).
void add_slots(const Json& object, std::vector<std::uint32_t>& sets) {
  for (const auto& [name, slot] : object.items()) {
    if (!name.ends_with("Texture") || !slot.is_object() || !slot.contains("index")) continue;
    std::uint64_t set = unsigned_field(slot, "texCoord");
    if (const Json* transform = extension_of(slot, "KHR_texture_transform")) {
      set = unsigned_field(*transform, "texCoord", set);
    }
    const auto number = static_cast<std::uint32_t>(std::min<std::uint64_t>(set, kAbsent));
    if (std::ranges::find(sets, number) == sets.end()) sets.push_back(number);
  }
}

}  // namespace

std::vector<std::vector<std::uint32_t>> texture_coordinates_needed(const Json& json) {
  std::vector<std::vector<std::uint32_t>> needed;
  for (const Json& material : list_field(json, "materials")) {
    std::vector<std::uint32_t>& sets = needed.emplace_back();
    add_slots(material, sets);
    const auto pbr = material.find("pbrMetallicRoughness");
    if (pbr != material.end()) add_slots(*pbr, sets);
    const auto extensions = material.find("extensions");
    if (extensions == material.end()) continue;
    for (const auto& [name, extension] : extensions->items()) {
      if (extension.is_object()) add_slots(extension, sets);
    }
  }
  return needed;
}

}  // namespace lightbatch::gltf
