#include "core/scene_out/references.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene_out/json_access.h"

namespace lightbatch::scene_out {
namespace {

// Extensions that hold no number of an accessor or view but under "bufferView" (sounds, profiles of
// lamps), whatever else they hold.
constexpr std::array<std::string_view, 12> kNoData{
    "KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture", "KHR_lights_", "KHR_node_",
    "KHR_xmp",        "OMI_",         "MOZ_",         "MSFT_lod",     "EXT_lights_", "KHR_audio"};
// Extensions whose numbers are followed elsewhere.
constexpr std::array<std::string_view, 2> kFollowed{"EXT_mesh_gpu_instancing",
                                                    "KHR_draco_mesh_compression"};

void visit_values(Json* object, const std::function<void(Json&)>& visit) {
  if (object == nullptr || !object->is_object()) return;
  for (auto& [key, value] : object->items())
    if (value.is_number_integer()) visit(value);
}

struct Pending {
  const Json* json;
  int kind;  // 0: outside extensions; 1: inside one of kNoData; 2: inside an unknown one
  bool mesh_key = false, view_key = false;
};

void pin_pointer(std::string_view text, Pins& pins) {
  constexpr std::string_view kNodes = "/nodes/", kMaterials = "/materials/";
  if (text.starts_with(kMaterials)) pins.materials = true;
  if (!text.starts_with(kNodes)) return;
  text.remove_prefix(kNodes.size());
  std::uint32_t node = 0;
  if (std::from_chars(text.data(), text.data() + text.size(), node).ec == std::errc())
    pins.nodes.insert(node);
  else
    pins.any_node = true;
}

}  // namespace

void for_each_accessor_of_mesh(Json& mesh, const std::function<void(Json&)>& visit) {
  Json* primitives = member(mesh, "primitives");
  if (primitives == nullptr) return;
  for (Json& primitive : *primitives) {
    visit_values(member(primitive, "attributes"), visit);
    if (Json* indices = member(primitive, "indices")) visit(*indices);
    if (Json* targets = member(primitive, "targets"))
      for (Json& target : *targets) visit_values(&target, visit);
  }
}

void for_each_accessor_outside_meshes(Json& root, const std::function<void(Json&)>& visit) {
  if (Json* skins = member(root, "skins"))
    for (Json& skin : *skins)
      if (Json* matrices = member(skin, "inverseBindMatrices")) visit(*matrices);
  if (Json* animations = member(root, "animations"))
    for (Json& animation : *animations)
      if (Json* samplers = member(animation, "samplers"))
        for (Json& sampler : *samplers)
          for (const char* key : {"input", "output"})
            if (Json* accessor = member(sampler, key)) visit(*accessor);
  if (Json* nodes = member(root, "nodes"))
    for (Json& node : *nodes)
      if (Json* extensions = member(node, "extensions"))
        if (Json* instancing = member(*extensions, "EXT_mesh_gpu_instancing"))
          visit_values(member(*instancing, "attributes"), visit);
}

Pins find_pins(const Json& root) {
  Pins pins;
  const auto starts_with_any = [](std::string_view name, auto& prefixes) {
    return std::any_of(prefixes.begin(), prefixes.end(),
                       [&](std::string_view p) { return name.starts_with(p); });
  };
  std::vector<Pending> stack{{&root, 0}};
  while (!stack.empty()) {
    const auto [json, kind, mesh_key, view_key] = stack.back();
    stack.pop_back();
    if (json->is_array()) {
      for (const Json& value : *json) stack.push_back({&value, kind, mesh_key, view_key});
    } else if (json->is_object()) {
      for (const auto& [key, value] : json->items()) {
        if (key == "extras") continue;
        if (key == "extensions" && value.is_object()) {
          for (const auto& [name, content] : value.items())
            if (!starts_with_any(name, kFollowed))
              stack.push_back({&content, starts_with_any(name, kNoData) ? 1 : 2});
          continue;
        }
        stack.push_back(
            {&value, kind, mesh_key || key.find("mesh") != std::string::npos, key == "bufferView"});
      }
    } else if (kind == 2 && json->is_string()) {
      pin_pointer(json->get_ref<const std::string&>(), pins);
    } else if (kind != 0 && json->is_number_integer()) {
      const auto number = json->get<std::int64_t>();
      if (number < 0 || number >= std::int64_t{kNone}) continue;
      const auto index = static_cast<std::uint32_t>(number);
      if (mesh_key || kind == 2) pins.meshes.insert(index);
      if (kind == 2) pins.accessors.insert(index);
      if (kind == 2 || view_key) pins.views.insert(index);
    }
  }
  return pins;
}

}  // namespace lightbatch::scene_out
