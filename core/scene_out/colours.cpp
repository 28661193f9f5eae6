#include "core/scene_out/colours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include "core/scene_out/corners.h"
#include "core/scene_out/references.h"

namespace lightbatch::scene_out {
namespace {

/// Extensions that take the base colour as the core material does.
constexpr std::array<std::string_view, 12> kPlain{
    "KHR_materials_anisotropy", "KHR_materials_clearcoat",   "KHR_materials_dispersion",
    "KHR_materials_ior",        "KHR_materials_iridescence", "KHR_materials_emissive_strength",
    "KHR_materials_sheen",      "KHR_materials_specular",    "KHR_materials_transmission",
    "KHR_materials_unlit",      "KHR_materials_volume",      "KHR_materials_diffuse_transmission"};

bool may_share(const Json& material) {
  if (material.contains("extras")) return false;
  if (const Json* pbr = member(material, "pbrMetallicRoughness"))
    if (pbr->contains("extensions") || pbr->contains("extras")) return false;
  if (const Json* extensions = member(material, "extensions"))
    for (const auto& [name, value] : extensions->items())
      if (std::find(kPlain.begin(), kPlain.end(), name) == kPlain.end()) return false;
  return true;
}

std::array<double, 4> factor_of(const Json& root, std::uint32_t material) {
  std::array<double, 4> factor{1, 1, 1, 1};
  if (material == kNone) return factor;
  if (const Json* pbr = member(root.at("materials").at(material), "pbrMetallicRoughness"))
    if (const Json* value = member(*pbr, "baseColorFactor"))
      for (std::size_t c = 0; c < 4; ++c) factor[c] = value->at(c).get<double>();
  return factor;
}

/// Factors are decimals of what was a byte in most tools.
bool is_byte(double value) {
  constexpr double kRounding = 5e-7;
  return std::abs(value - std::round(255 * value) / 255) <= kRounding;
}

}  // namespace

std::vector<std::uint32_t> material_classes(const Json& root, const scene::Scene& scene,
                                            bool baked) {
  std::vector<std::uint32_t> classes(scene.materials.size());
  std::map<std::string, std::uint32_t> known;
  const bool named = find_pins(root).materials;
  for (std::uint32_t m = 0; m < classes.size(); ++m) {
    classes[m] = m;
    const std::uint32_t index = scene.materials[m].gltf_index;
    if (named || index == kNone || !may_share(root.at("materials").at(index))) continue;
    if (baked && is_emissive(root.at("materials").at(index))) continue;
    Json rest = root.at("materials").at(index);
    rest.erase("name");
    if (Json* pbr = member(rest, "pbrMetallicRoughness"))
      if (!pbr->contains("baseColorTexture")) pbr->erase("baseColorFactor");
    rest["alpha"] = factor_of(root, index)[3];
    classes[m] = known.try_emplace(rest.dump(), m).first->second;
  }
  return classes;
}

bool colours_differ(const Writer& w, std::span<const batches::Piece> pieces) {
  const auto factor = [&](const batches::Piece& piece) {
    return factor_of(w.document.json, w.gltf_material(w.scene.objects[piece.object].material));
  };
  return std::any_of(pieces.begin(), pieces.end(), [&](const batches::Piece& piece) {
    return factor(piece) != factor(pieces.front());
  });
}

CornerStream colour_stream(const Writer& w, std::span<const IndexRange> ranges) {
  std::vector<std::array<double, 4>> factors;
  bool bytes = true;
  for (const IndexRange& range : ranges) {
    const std::uint32_t material = w.scene.objects[range.object].material;
    factors.push_back(factor_of(w.document.json, w.gltf_material(material)));
    for (std::size_t c = 0; c < 3; ++c) bytes = bytes && is_byte(factors.back()[c]);
  }
  CornerStream stream{{"COLOR_0", bytes ? 5121 : 5126, bytes, "VEC3", 3}, {}};
  for (std::size_t r = 0; r < ranges.size(); ++r) {
    Bytes one;
    for (std::size_t c = 0; c < 3; ++c) push_component(stream.type, factors[r][c], one);
    for (std::uint32_t i = 0; i < ranges[r].count; ++i)
      stream.bytes.insert(stream.bytes.end(), one.begin(), one.end());
  }
  return stream;
}

}  // namespace lightbatch::scene_out
