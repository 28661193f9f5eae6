#include "core/gltf/extensions.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "core/gltf/fields.h"

namespace lightbatch::gltf {
namespace {

/// Understood: decoded here, or read by scene_in.
constexpr std::array<std::string_view, 14> kUnderstood = {
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "MSFT_texture_dds",
};

/// Passed through: they change neither where surfaces are nor the light that leaves them by diffuse
/// reflection, beyond what a model of that reflection ignores anyway.
constexpr std::array<std::string_view, 16> kPassedThrough = {
    "EXT_texture_avif",          "KHR_animation_pointer",
    "KHR_materials_anisotropy",  "KHR_materials_clearcoat",
    "KHR_materials_dispersion",  "KHR_materials_ior",
    "KHR_materials_iridescence", "KHR_materials_sheen",
    "KHR_materials_specular",    "KHR_materials_variants",
    "KHR_materials_volume",      "KHR_node_visibility",
    "KHR_xmp_json_ld",           "MOZ_lightmap",
    "OMI_physics_body",          "OMI_physics_shape",
};

bool is_listed(const Json& names, const std::string& name) {
  return std::any_of(names.begin(), names.end(), [&name](const Json& entry) {
    return entry.get_ref<const std::string&>() == name;
  });
}

}  // namespace

Status check_required_extensions(const Json& json, const JsonPath& root,
                                 std::vector<std::string>& warnings) {
  const Json& required = list_field(json, "extensionsRequired");
  const Json& used = list_field(json, "extensionsUsed");
  const JsonPath list(root, "extensionsRequired");
  for (std::size_t i = 0; i < required.size(); ++i) {
    const std::string& name = required[i].get_ref<const std::string&>();
    const JsonPath path(list, i);
    const bool understood = std::ranges::find(kUnderstood, name) != kUnderstood.end();
    const bool passed =
        std::ranges::find(kPassedThrough, name) != kPassedThrough.end() || name.starts_with("OMI_");
    if (!understood && !passed) {
      return unsupported(path.text(), "the scene requires the extension " + name.substr(0, 80) +
                                          ", which is not supported");
    }
    if (!is_listed(used, name)) {
      return malformed(path.text(), name.substr(0, 80) + " is required but not listed as used");
    }
  }
  if (is_listed(used, "KHR_mesh_quantization") && !is_listed(required, "KHR_mesh_quantization")) {
    warnings.push_back(root.text() +
                       "/extensionsUsed: KHR_mesh_quantization should be listed as required");
  }
  return {};
}

void erase_extension(Json& object, const char* name) {
  const auto extensions = object.find("extensions");
  if (extensions == object.end()) return;
  extensions->erase(name);
  if (extensions->empty()) object.erase("extensions");
}

void undeclare_extension(Json& json, const char* name) {
  for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
    const auto names = json.find(list);
    if (names == json.end()) continue;
    Json kept = Json::array();
    for (Json& entry : *names) {
      if (entry.get_ref<const std::string&>() != name) kept.push_back(std::move(entry));
    }
    if (kept.empty()) {
      json.erase(list);
    } else {
      *names = std::move(kept);
    }
  }
}

}  // namespace lightbatch::gltf
