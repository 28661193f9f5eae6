#include "core/generate/materials.h"

#include <array>

namespace lightbatch::generate {
namespace {

struct Entry {
  const char* name;
  double r, g, b;
  double metallic = 0;
  double roughness = 0.9;
  double nits = 0;
  bool double_sided = false;
};

constexpr std::array<Entry, kMaterialCount> kTable = {{
    {"facade", 0.42, 0.38, 0.33},
    {"carpet", 0.12, 0.14, 0.17, 0, 1.0},
    {"tiles", 0.46, 0.44, 0.40, 0, 0.4},
    {"ceiling", 0.82, 0.82, 0.80},
    {"plastic", 0.05, 0.05, 0.055, 0, 0.6},
    {"steel", 0.55, 0.56, 0.57, 0.9, 0.35},
    {"screen", 0.015, 0.015, 0.018, 0, 0.2},
    {"soil", 0.09, 0.06, 0.04, 0, 1.0},
    {"leaf", 0.08, 0.20, 0.05, 0, 0.7, 0, true},
    {"porcelain", 0.75, 0.74, 0.70, 0, 0.3},
    {"lamp warm", 1.0, 0.93, 0.80, 0, 0.9, 3500},
    {"lamp cool", 0.93, 0.97, 1.0, 0, 0.9, 3500},
    {"paint white", 0.78, 0.77, 0.74},
    {"paint cream", 0.72, 0.66, 0.52},
    {"paint blue", 0.42, 0.53, 0.62},
    {"paint green", 0.50, 0.60, 0.46},
    {"fabric red", 0.35, 0.06, 0.05, 0, 1.0},
    {"fabric blue", 0.05, 0.10, 0.28, 0, 1.0},
    {"fabric grey", 0.18, 0.18, 0.19, 0, 1.0},
    {"fabric mustard", 0.46, 0.30, 0.05, 0, 1.0},
    {"wood beech", 0.52, 0.36, 0.21, 0, 0.6},
    {"wood oak", 0.40, 0.26, 0.13, 0, 0.6},
    {"wood walnut", 0.16, 0.09, 0.05, 0, 0.6},
    {"wood white", 0.70, 0.69, 0.66, 0, 0.6},
    {"cover red", 0.40, 0.05, 0.04},
    {"cover green", 0.06, 0.22, 0.09},
    {"cover blue", 0.05, 0.12, 0.35},
    {"cover cream", 0.66, 0.60, 0.46},
}};

}  // namespace

nlohmann::json material_table() {
  nlohmann::json table = nlohmann::json::array();
  for (const Entry& entry : kTable) {
    nlohmann::json material = {{"name", entry.name},
                               {"pbrMetallicRoughness",
                                {{"baseColorFactor", {entry.r, entry.g, entry.b, 1.0}},
                                 {"metallicFactor", entry.metallic},
                                 {"roughnessFactor", entry.roughness}}}};
    if (entry.double_sided) material["doubleSided"] = true;
    if (entry.nits > 0) {
      material["pbrMetallicRoughness"]["baseColorFactor"] = {0.8, 0.8, 0.8, 1.0};
      material["emissiveFactor"] = {entry.r, entry.g, entry.b};
      material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = entry.nits;
    }
    table.push_back(std::move(material));
  }
  return table;
}

}  // namespace lightbatch::generate
