#include "core/scene_out/lit_objects.h"

#include <cstring>

#include "core/scene_out/mesh_builder.h"

namespace lightbatch::scene_out {
namespace {

constexpr std::uint32_t kUnset = kNone - 1;

/// TEXCOORD_1 of each corner and page of each triangle of the source; (0, 0) where there is no
/// light.
struct ObjectLight {
  std::vector<Vec2f> uv;
  std::vector<std::uint32_t> page;
  bool one_page = true;
};

ObjectLight light_of(const Writer& w, const SourcePrimitive& source, std::uint32_t index) {
  const scene::Object& object = w.scene.objects[index];
  ObjectLight light;
  light.uv.resize(source.corners.size());
  light.page.assign(source.corners.size() / 3, kUnset);
  for (std::uint32_t k = 0; k < object.triangle_count; ++k) {
    const std::uint32_t t = object.first_triangle + k;
    const std::uint32_t at = w.scene.triangles[t].source;
    light.page[at] = w.page_of(t);
    if (light.page[at] == kNone) continue;
    auto uv = w.uv1_of(t);
    if (object.mirrored) std::swap(uv[1], uv[2]);
    for (std::size_t c = 0; c < 3; ++c) light.uv[3 * std::size_t{at} + c] = uv[c];
  }
  // Triangles that the scene dropped have no area: they go with their neighbours.
  std::uint32_t last = kNone;
  for (const std::uint32_t page : light.page)
    if (page != kUnset) {
      last = page;
      break;
    }
  for (std::uint32_t& page : light.page) {
    if (page == kUnset) page = last;
    last = page;
  }
  for (std::size_t i = 0; i < light.page.size(); ++i)
    light.one_page = light.one_page && light.page[i] == light.page[0];
  return light;
}

bool reads_set_1(const Json& root, const Json& primitive, std::uint32_t material) {
  bool reads = uses_uv_set(root, material, 1);
  if (const Json* variants = extension(primitive, "KHR_materials_variants"))
    if (const Json* mappings = member(*variants, "mappings"))
      for (const Json& m : *mappings)
        reads = reads || uses_uv_set(root, index_at(m, "material"), 1);
  return reads;
}

}  // namespace

Result<std::vector<Json>> lit_primitives(Writer& w, const std::vector<std::uint32_t>& objects) {
  const scene::Object& first = w.scene.objects[objects.front()];
  LB_ASSIGN_OR_RETURN(const SourcePrimitive* source, w.sources.get(first.mesh, first.primitive));
  const Json& json =
      w.document.json.at("meshes").at(first.mesh).at("primitives").at(first.primitive);
  const std::uint32_t material = index_at(json, "material");

  std::vector<ObjectLight> lights;
  std::vector<std::uint32_t> ids = source->corners;
  std::uint32_t vertex_count = source->vertex_count();
  bool shared_indices = true;
  for (const std::uint32_t o : objects) {
    lights.push_back(light_of(w, *source, o));
    vertex_count = refine_ids(ids, std::as_bytes(std::span(lights.back().uv)), sizeof(Vec2f));
    shared_indices = shared_indices && lights.back().one_page;
  }

  const std::uint32_t moved =
      reads_set_1(w.document.json, json, material) ? free_uv_set(source->types) : kNone;
  std::vector<std::size_t> corner_of(vertex_count, 0);
  for (std::size_t c = ids.size(); c-- > 0;) corner_of[ids[c]] = c;
  Json attributes = Json::object();
  for (std::size_t s = 0; s < source->types.size(); ++s) {
    AttributeType type = source->types[s];
    if (type.name == "TEXCOORD_1") {
      if (moved == kNone) continue;
      type.name = "TEXCOORD_" + std::to_string(moved);
    }
    const std::size_t size = type.bytes();
    Bytes bytes(vertex_count * size);
    for (std::uint32_t v = 0; v < vertex_count; ++v)
      std::memcpy(bytes.data() + v * size,
                  source->data[s].data() + source->corners[corner_of[v]] * size, size);
    attributes[type.name] = w.binary.add_attribute(type, bytes);
  }
  std::uint32_t all_indices = kUnset;
  if (shared_indices) all_indices = w.binary.add_indices(ids);

  std::vector<Json> result;
  for (const ObjectLight& light : lights) {
    std::vector<Vec2f> uv(vertex_count);
    for (std::uint32_t v = 0; v < vertex_count; ++v) uv[v] = light.uv[corner_of[v]];
    const std::uint32_t uv_accessor = w.binary.add_attribute({"TEXCOORD_1", 5126, false, "VEC2", 2},
                                                             std::as_bytes(std::span(uv)));
    std::map<std::uint32_t, std::vector<std::uint32_t>> by_page;
    for (std::size_t t = 0; t < light.page.size(); ++t) {
      auto& list = by_page[light.page[t]];
      if (!shared_indices)
        list.insert(list.end(), ids.begin() + static_cast<std::ptrdiff_t>(3 * t),
                    ids.begin() + static_cast<std::ptrdiff_t>(3 * t + 3));
    }
    Json primitives = Json::array();
    for (const auto& [page, list] : by_page) {
      Json primitive = json;
      primitive.erase("mode");
      primitive["attributes"] = attributes;
      primitive["indices"] = shared_indices ? all_indices : w.binary.add_indices(list);
      if (page != kNone) {
        primitive["attributes"]["TEXCOORD_1"] = uv_accessor;
        fill_uv_sets(primitive["attributes"]);
        primitive["material"] = w.materials.with_lightmap(material, page, moved);
        if (const Json* variants = extension(primitive, "KHR_materials_variants"))
          if (variants->contains("mappings"))
            for (Json& m : primitive["extensions"]["KHR_materials_variants"]["mappings"])
              m["material"] = w.materials.with_lightmap(index_at(m, "material"), page, moved);
      }
      primitives.push_back(std::move(primitive));
    }
    result.push_back(std::move(primitives));
  }
  return result;
}

}  // namespace lightbatch::scene_out
