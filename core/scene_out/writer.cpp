#include "core/scene_out/writer.h"

#include <charconv>

namespace lightbatch::scene_out {

std::uint32_t free_uv_set(const std::vector<AttributeType>& types) {
  std::uint32_t free = 2;
  constexpr std::string_view kPrefix = "TEXCOORD_";
  for (const AttributeType& type : types) {
    if (!type.name.starts_with(kPrefix)) continue;
    const std::string_view digits = std::string_view(type.name).substr(kPrefix.size());
    std::uint32_t set = 0;
    const auto parsed = std::from_chars(digits.data(), digits.data() + digits.size(), set);
    if (parsed.ec == std::errc() && set < 1000) free = std::max(free, set + 1);
  }
  return free;
}

void fill_uv_sets(Json& attributes) {
  const Json* second = member(attributes, "TEXCOORD_1");
  if (second == nullptr || attributes.contains("TEXCOORD_0")) return;
  const Json accessor = *second;
  attributes["TEXCOORD_0"] = accessor;
}

Json add_primitive(NewBinary& binary, const std::vector<AttributeType>& types,
                   const std::vector<Bytes>& data, std::span<const std::uint32_t> indices) {
  Json primitive;
  for (std::size_t s = 0; s < types.size(); ++s)
    primitive["attributes"][types[s].name] = binary.add_attribute(types[s], data[s]);
  fill_uv_sets(primitive["attributes"]);
  primitive["indices"] = binary.add_indices(indices);
  return primitive;
}

std::uint32_t Writer::part_of_mesh(std::uint32_t mesh,
                                   const std::vector<std::uint32_t>& primitives) {
  const auto [it, fresh] = parts_.try_emplace({mesh, primitives}, 0);
  if (!fresh) return it->second;
  Json part = document.json.at("meshes").at(mesh);
  Json kept = Json::array();
  for (const std::uint32_t p : primitives) kept.push_back(part.at("primitives").at(p));
  part["primitives"] = std::move(kept);
  it->second = append(root, "meshes", std::move(part));
  return it->second;
}

}  // namespace lightbatch::scene_out
