#include "core/scene_out/materials.h"

#include <algorithm>
#include <string>
#include <string_view>

#include "core/scene_out/json_access.h"

namespace lightbatch::scene_out {
namespace {

constexpr const char* kLightmap = "MOZ_lightmap";
constexpr const char* kTransform = "KHR_texture_transform";

/// The set that a textureInfo reads: KHR_texture_transform overrides texCoord.
std::uint32_t set_of(const Json& info) {
  if (const Json* transform = extension(info, kTransform))
    if (const std::uint32_t set = index_at(*transform, "texCoord"); set != kNone) return set;
  const std::uint32_t set = index_at(info, "texCoord");
  return set == kNone ? 0 : set;
}

/// Calls visit(info) for every textureInfo below: an object with a texture index whose key ends in
/// "Texture" (core and every KHR_materials extension name them so). Lightmaps are left out.
template <typename J, typename Visit>
void for_each_texture(J& json, const Visit& visit, int depth = 0) {
  constexpr int kDeepest = 8;  // extensions of extensions; a material is 4 deep at most
  if (!json.is_object() || depth > kDeepest) return;
  for (auto it = json.begin(); it != json.end(); ++it) {
    const std::string& key = it.key();
    if (key == kLightmap || key == "extras") continue;
    auto& value = it.value();
    if (key.ends_with("Texture") && index_at(value, "index") != kNone) visit(value);
    for_each_texture(value, visit, depth + 1);
  }
}

/// Calls visit(slot) for every place that holds the number of a material.
template <typename Visit>
void for_each_material_slot(Json& root, const Visit& visit) {
  Json* meshes = member(root, "meshes");
  if (meshes == nullptr) return;
  for (Json& mesh : *meshes)
    for (Json& primitive : mesh["primitives"]) {
      if (Json* slot = member(primitive, "material")) visit(*slot);
      Json* extensions = member(primitive, "extensions");
      Json* variants =
          extensions == nullptr ? nullptr : member(*extensions, "KHR_materials_variants");
      Json* mappings = variants == nullptr ? nullptr : member(*variants, "mappings");
      if (mappings == nullptr) continue;
      for (Json& mapping : *mappings)
        if (Json* slot = member(mapping, "material")) visit(*slot);
    }
}

}  // namespace

bool is_thick(const Json& root, const Json& primitive) {
  const auto thick = [&](std::uint32_t material) {
    if (material == kNone) return false;
    const Json* volume = extension(root.at("materials").at(material), "KHR_materials_volume");
    const Json* thickness = volume == nullptr ? nullptr : member(*volume, "thicknessFactor");
    return thickness != nullptr && thickness->is_number() && thickness->get<double>() != 0;
  };
  if (thick(index_at(primitive, "material"))) return true;
  const Json* variants = extension(primitive, "KHR_materials_variants");
  const Json* mappings = variants == nullptr ? nullptr : member(*variants, "mappings");
  if (mappings == nullptr) return false;
  return std::any_of(mappings->begin(), mappings->end(),
                     [&](const Json& mapping) { return thick(index_at(mapping, "material")); });
}

Clones settle_materials(Json& root, std::uint32_t original, Clones clones) {
  Json* materials = member(root, "materials");
  if (materials == nullptr || clones.empty()) return clones;
  std::vector<bool> used(original, false);
  for_each_material_slot(root, [&](const Json& slot) {
    const auto index = slot.get<std::size_t>();
    if (index < original) used[index] = true;
  });
  std::vector<std::uint32_t> number(materials->size());
  for (std::uint32_t i = 0; i < number.size(); ++i) number[i] = i;
  std::vector<bool> moved(number.size(), false);
  for (const auto& [source, clone] : clones) {
    if (used[source]) continue;
    used[source] = true;
    (*materials)[source] = std::move((*materials)[clone]);
    number[clone] = source;
    moved[clone] = true;
  }
  Json kept = Json::array();
  for (std::uint32_t i = 0; i < number.size(); ++i) {
    if (moved[i]) continue;
    number[i] = static_cast<std::uint32_t>(kept.size());
    kept.push_back(std::move((*materials)[i]));
  }
  *materials = std::move(kept);
  for_each_material_slot(root, [&](Json& slot) {
    const auto index = slot.get<std::size_t>();
    slot = number[index];
  });
  for (auto& [source, clone] : clones) clone = number[clone];
  return clones;
}

void animate_clones(Json& root, const Clones& clones) {
  Json* animations = member(root, "animations");
  if (animations == nullptr || clones.empty()) return;
  constexpr std::string_view kMaterials = "/materials/";
  for (Json& animation : *animations) {
    Json* channels = member(animation, "channels");
    if (channels == nullptr) continue;
    Json added = Json::array();
    for (const Json& channel : *channels) {
      const Json* target = extension(channel.at("target"), "KHR_animation_pointer");
      const Json* pointer = target == nullptr ? nullptr : member(*target, "pointer");
      if (pointer == nullptr || !pointer->is_string()) continue;
      const auto text = pointer->get<std::string>();
      if (!text.starts_with(kMaterials)) continue;
      const std::size_t end = std::min(text.find('/', kMaterials.size()), text.size());
      const std::string number = text.substr(kMaterials.size(), end - kMaterials.size());
      for (const auto& [source, clone] : clones) {
        if (number != std::to_string(source) || clone == source) continue;
        Json copy = channel;
        copy["target"]["extensions"]["KHR_animation_pointer"]["pointer"] =
            std::string(kMaterials) + std::to_string(clone) + text.substr(end);
        added.push_back(std::move(copy));
      }
    }
    for (Json& channel : added) channels->push_back(std::move(channel));
  }
}

bool is_emissive(const Json& material) {
  const Json* factor = member(material, "emissiveFactor");
  return factor != nullptr && factor->is_array() &&
         std::any_of(factor->begin(), factor->end(),
                     [](const Json& c) { return c.is_number() && c.get<double>() > 0; });
}

Json clones_of_emitters(const Json& root, const Clones& clones) {
  Json emitters = Json::object();
  for (const auto& [source, clone] : clones)
    if (is_emissive(root.at("materials").at(clone)))
      emitters[std::to_string(source)].push_back(clone);
  return emitters;
}

bool uses_uv_set(const Json& root, std::uint32_t material, std::uint32_t set) {
  if (material == kNone) return false;
  bool used = false;
  for_each_texture(root.at("materials").at(material),
                   [&](const Json& info) { used = used || set_of(info) == set; });
  return used;
}

BakedMaterials::BakedMaterials(Json& root) : root_(root), original_(count_of(root, "materials")) {}

Json BakedMaterials::copy_of(std::uint32_t material) const {
  return material == kNone ? Json::object() : root_.at("materials").at(material);
}

std::uint32_t BakedMaterials::add(std::uint32_t material, Json clone) {
  const std::uint32_t index = append(root_, "materials", std::move(clone));
  if (material < original_) clones_.emplace_back(material, index);
  return index;
}

std::uint32_t BakedMaterials::with_lightmap(std::uint32_t material, std::uint32_t page,
                                            std::uint32_t moved_set) {
  const auto [it, fresh] = lightmapped_.try_emplace({material, page, moved_set}, material);
  if (!fresh) return it->second;
  Json clone = copy_of(material);
  const bool unlit = extension(clone, "KHR_materials_unlit") != nullptr;
  if (unlit && moved_set == kNone) return material;
  if (moved_set != kNone)
    for_each_texture(clone, [&](Json& info) {
      if (set_of(info) != 1) return;
      info["texCoord"] = moved_set;
      if (Json* transform = const_cast<Json*>(extension(info, kTransform)))
        if (transform->contains("texCoord")) (*transform)["texCoord"] = moved_set;
    });
  if (!unlit)
    clone["extensions"][kLightmap] = {
        {"index", textures_.at(page)}, {"texCoord", 1}, {"intensity", intensity_.at(page)}};
  it->second = add(material, std::move(clone));
  return it->second;
}

std::uint32_t BakedMaterials::coloured(std::uint32_t material) {
  const auto [it, fresh] = coloured_.try_emplace(material, 0);
  if (!fresh) return it->second;
  Json clone = copy_of(material);
  clone["name"] = "vertex_colours_" + std::to_string(coloured_.size() - 1);
  Json& pbr = clone["pbrMetallicRoughness"];
  if (pbr.is_null()) pbr = Json::object();
  if (Json* factor = member(pbr, "baseColorFactor")) *factor = {1, 1, 1, factor->at(3)};
  it->second = append(root_, "materials", std::move(clone));
  return it->second;
}

std::uint32_t BakedMaterials::unlit(std::uint32_t material, bool colour_in_vertices) {
  const auto [it, fresh] = unlit_.try_emplace({material, colour_in_vertices}, 0);
  if (!fresh) return it->second;
  const Json source = copy_of(material);
  // Only what an unlit reader looks at: other lighting extensions beside unlit are contradictions.
  Json clone = Json::object();
  for (const char* key : {"name", "extras", "alphaMode", "alphaCutoff", "doubleSided"})
    if (const Json* value = member(source, key)) clone[key] = *value;
  Json base = Json::object();
  if (const Json* pbr = member(source, "pbrMetallicRoughness"))
    for (const char* key : {"baseColorFactor", "baseColorTexture"})
      if (const Json* value = member(*pbr, key)) base[key] = *value;
  if (colour_in_vertices) {
    const double alpha =
        base.contains("baseColorFactor") ? base["baseColorFactor"].at(3).get<double>() : 1;
    base["baseColorFactor"] = {1, 1, 1, alpha};
  }
  base["metallicFactor"] = 0;
  base["roughnessFactor"] = 0.9;
  clone["pbrMetallicRoughness"] = std::move(base);
  clone["extensions"]["KHR_materials_unlit"] = Json::object();
  it->second = add(material, std::move(clone));
  return it->second;
}

}  // namespace lightbatch::scene_out
