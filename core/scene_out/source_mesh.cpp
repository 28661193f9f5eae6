#include "core/scene_out/source_mesh.h"

#include "core/gltf/accessor.h"
#include "core/scene_out/json_access.h"

namespace lightbatch::scene_out {
namespace {

int components_of(const std::string& type) {
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  if (type == "VEC3") return 3;
  if (type == "VEC4" || type == "MAT2") return 4;
  return type == "MAT3" ? 9 : 16;
}

constexpr std::uint32_t kTriangles = 4, kStrip = 5, kFan = 6;

std::vector<std::uint32_t> triangle_list(const std::vector<std::uint32_t>& v, std::uint32_t mode) {
  if (mode == kTriangles)
    return {v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 3 * 3)};
  std::vector<std::uint32_t> list;
  for (std::size_t i = 0; i + 2 < v.size(); ++i) {
    if (mode == kStrip)
      list.insert(list.end(), {v[i], v[i + 1 + i % 2], v[i + 2 - i % 2]});
    else
      list.insert(list.end(), {v[i + 1], v[i + 2], v[0]});
  }
  return list;
}

}  // namespace

std::size_t AttributeType::component_bytes() const {
  switch (component_type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    default:
      return 4;
  }
}

std::vector<AttributeType> attribute_types(const Json& root, const Json& primitive) {
  std::vector<AttributeType> types;
  const Json* attributes = member(primitive, "attributes");
  if (attributes == nullptr) return types;
  for (const auto& [name, value] : attributes->items()) {
    const Json& accessor = root.at("accessors").at(value.get<std::size_t>());
    AttributeType type;
    type.name = name;
    type.component_type = accessor.at("componentType").get<int>();
    type.normalized = accessor.value("normalized", false);
    type.type = accessor.at("type").get<std::string>();
    type.components = components_of(type.type);
    types.push_back(std::move(type));
  }
  return types;
}

Result<const SourcePrimitive*> SourceMeshes::get(std::uint32_t mesh, std::uint32_t primitive) {
  auto& slot = read_[{mesh, primitive}];
  if (slot != nullptr) return slot.get();
  const Json& json = document_.json.at("meshes").at(mesh).at("primitives").at(primitive);
  auto source = std::make_unique<SourcePrimitive>();
  source->types = attribute_types(document_.json, json);
  for (const AttributeType& type : source->types) {
    const std::uint32_t accessor = index_at(json.at("attributes"), type.name);
    LB_ASSIGN_OR_RETURN(Bytes bytes, gltf::read_packed(document_, accessor));
    source->data.push_back(std::move(bytes));
    if (type.name != "POSITION") continue;
    LB_ASSIGN_OR_RETURN(const gltf::Values values, gltf::read_values(document_, accessor));
    for (std::size_t i = 0; i + 2 < values.data.size(); i += 3)
      source->positions.push_back({values.data[i], values.data[i + 1], values.data[i + 2]});
  }
  std::vector<std::uint32_t> indices;
  if (const std::uint32_t accessor = index_at(json, "indices"); accessor != kNone) {
    LB_ASSIGN_OR_RETURN(indices, gltf::read_indices(document_, accessor));
  } else {
    indices.resize(source->positions.size());
    for (std::uint32_t i = 0; i < indices.size(); ++i) indices[i] = i;
  }
  const std::uint32_t mode = index_at(json, "mode");
  source->corners = triangle_list(indices, mode == kNone ? kTriangles : mode);
  for (const std::uint32_t v : source->corners)
    if (v >= source->vertex_count())
      return malformed(document_.name + "#/meshes/" + std::to_string(mesh) + "/primitives/" +
                           std::to_string(primitive) + "/indices",
                       "an index is beyond the vertices");
  slot = std::move(source);
  return slot.get();
}

}  // namespace lightbatch::scene_out
