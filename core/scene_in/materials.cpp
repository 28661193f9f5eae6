#include "core/scene_in/materials.h"

#include <algorithm>
#include <cmath>

namespace lightbatch::scene_in {
namespace {

constexpr double kLargestEmission = 1e30;  // nits; keeps every product of light finite

/// Brings factors into their range and says so once per material.
class Clamp {
 public:
  double operator()(double value, double low, double high) {
    const double clamped = std::clamp(value, low, high);
    if (clamped != value) happened = true;
    return clamped;
  }
  bool happened = false;
};

double item(const std::vector<double>& values, std::size_t i, double fallback) {
  return i < values.size() ? values[i] : fallback;
}

Rgb unit_color(Clamp& clamp, double r, double g, double b) {
  return to_float(Rgbd{clamp(r, 0, 1), clamp(g, 0, 1), clamp(b, 0, 1)});
}

void read_metallic(const tinygltf::Material& source, Clamp& clamp, const std::string& place,
                   TextureReader& textures, scene::Material& material) {
  const auto& pbr = source.pbrMetallicRoughness;
  material.base_color =
      unit_color(clamp, item(pbr.baseColorFactor, 0, 1), item(pbr.baseColorFactor, 1, 1),
                 item(pbr.baseColorFactor, 2, 1));
  material.alpha = static_cast<float>(clamp(item(pbr.baseColorFactor, 3, 1), 0, 1));
  material.base_color_texture =
      textures.slot(pbr.baseColorTexture.index, pbr.baseColorTexture.texCoord,
                    pbr.baseColorTexture.extensions, place + "/baseColorTexture");
  material.metallic = static_cast<float>(clamp(pbr.metallicFactor, 0, 1));
  if (material.metallic > 0) {
    const auto& texture = pbr.metallicRoughnessTexture;
    material.metallic_texture = textures.slot(texture.index, texture.texCoord, texture.extensions,
                                              place + "/metallicRoughnessTexture");
  }
}

/// KHR_materials_pbrSpecularGlossiness: its diffuse colour is the base colour of a dielectric.
void read_glossiness(const tinygltf::Value& source, Clamp& clamp, const std::string& place,
                     TextureReader& textures, scene::Material& material) {
  material.base_color =
      unit_color(clamp, number(source, "diffuseFactor", 0, 1),
                 number(source, "diffuseFactor", 1, 1), number(source, "diffuseFactor", 2, 1));
  material.alpha = static_cast<float>(clamp(number(source, "diffuseFactor", 3, 1), 0, 1));
  material.base_color_texture = textures.slot(source, "diffuseTexture", place + "/diffuseTexture");
  material.metallic = 0;
}

void read_emission(const tinygltf::Material& source, Clamp& clamp, const std::string& place,
                   TextureReader& textures, scene::Material& material) {
  double strength = 1;
  if (const auto* found = extension(source.extensions, "KHR_materials_emissive_strength")) {
    strength = clamp(number(*found, "emissiveStrength", 1), 0, kLargestEmission);
  }
  const auto channel = [&](std::size_t i) {
    return clamp(clamp(item(source.emissiveFactor, i, 0), 0, kLargestEmission) * strength, 0,
                 kLargestEmission);
  };
  material.emission = to_float(Rgbd{channel(0), channel(1), channel(2)});
  if (!material.emission.is_black()) {
    const auto& texture = source.emissiveTexture;
    material.emission_texture = textures.slot(texture.index, texture.texCoord, texture.extensions,
                                              place + "/emissiveTexture");
  }
}

void read_transmission(const tinygltf::Material& source, Clamp& clamp, const std::string& place,
                       TextureReader& textures, scene::Material& material) {
  if (const auto* found = extension(source.extensions, "KHR_materials_transmission")) {
    material.transmission =
        static_cast<float>(clamp(number(*found, "transmissionFactor", 0), 0, 1));
    if (material.transmission > 0) {
      material.transmission_texture =
          textures.slot(*found, "transmissionTexture", place + "/transmissionTexture");
    }
  }
  if (const auto* found = extension(source.extensions, "KHR_materials_diffuse_transmission")) {
    constexpr const char* kColor = "diffuseTransmissionColorFactor";
    material.diffuse_transmission =
        static_cast<float>(clamp(number(*found, "diffuseTransmissionFactor", 0), 0, 1));
    material.diffuse_transmission_color =
        unit_color(clamp, number(*found, kColor, 0, 1), number(*found, kColor, 1, 1),
                   number(*found, kColor, 2, 1));
    if (material.diffuse_transmission > 0) {
      constexpr const char* kFactor = "diffuseTransmissionTexture";
      constexpr const char* kColorTexture = "diffuseTransmissionColorTexture";
      material.diffuse_transmission_texture = textures.slot(*found, kFactor, place + "/" + kFactor);
      material.diffuse_transmission_color_texture =
          textures.slot(*found, kColorTexture, place + "/" + kColorTexture);
    }
  }
}

}  // namespace

scene::Material read_material(const tinygltf::Model& model, std::uint32_t index,
                              const std::string& file, TextureReader& textures,
                              std::vector<std::string>& warnings) {
  scene::Material material;
  if (index == scene::kNone) {
    material.name = "default";
    return material;
  }
  const tinygltf::Material& source = model.materials[index];
  const std::string place = file + "#/materials/" + std::to_string(index);
  Clamp clamp;
  material.name = source.name;
  material.gltf_index = index;
  if (const auto* found = extension(source.extensions, "KHR_materials_pbrSpecularGlossiness")) {
    read_glossiness(*found, clamp, place, textures, material);
  } else {
    read_metallic(source, clamp, place, textures, material);
  }
  read_emission(source, clamp, place, textures, material);
  read_transmission(source, clamp, place, textures, material);
  if (source.alphaMode == "MASK") {
    material.alpha_mode = scene::AlphaMode::kMask;
  } else if (source.alphaMode == "BLEND") {
    material.alpha_mode = scene::AlphaMode::kBlend;
  } else if (source.alphaMode != "OPAQUE" && !source.alphaMode.empty()) {
    warnings.push_back(place + ": unknown alphaMode, taken as OPAQUE");
  }
  material.alpha_cutoff = static_cast<float>(clamp(source.alphaCutoff, 0, 1e30));
  material.double_sided = source.doubleSided;
  material.unlit = source.extensions.contains("KHR_materials_unlit");
  material.has_normal_map = source.normalTexture.index >= 0;
  if (clamp.happened) warnings.push_back(place + ": a factor was out of its range and is clamped");
  return material;
}

}  // namespace lightbatch::scene_in
