#include "core/scene_out/portable.h"

#include <algorithm>
#include <numbers>

#include "core/scene_out/corners.h"
#include "core/scene_out/vertex_light.h"

namespace lightbatch::scene_out {
namespace {

const AttributeType kColour{"COLOR_0", 5123, true, "VEC4", 4};

/// What light makes of the surface.
Rgb colour_of(const scene::Material& material, const Rgb& irradiance, double exposure) {
  const Rgb colour = irradiance * static_cast<float>(exposure / std::numbers::pi);
  return colour_holds_all(material) ? colour * material.base_color : colour;
}

/// COLOR_0 of the source, which goes on multiplying; white without one.
struct SourceColour {
  const AttributeType* type = nullptr;
  const Bytes* data = nullptr;
  double at(std::uint32_t vertex, std::size_t c) const {
    if (type == nullptr || c >= static_cast<std::size_t>(type->components)) return 1;
    return component(*type, data->data() + vertex * type->bytes(), c);
  }
};

SourceColour source_colour(const SourcePrimitive& source) {
  for (std::size_t s = 0; s < source.types.size(); ++s)
    if (source.types[s].name == "COLOR_0") return {&source.types[s], &source.data[s]};
  return {};
}

CornerPlan plan_without_colour(const SourcePrimitive& source) {
  CornerPlan plan = plan_corners(source.types, false, kNone);
  for (std::size_t k = 0; k < plan.types.size(); ++k)
    if (plan.types[k].name == "COLOR_0") {
      plan.types.erase(plan.types.begin() + static_cast<std::ptrdiff_t>(k));
      plan.source.erase(plan.source.begin() + static_cast<std::ptrdiff_t>(k));
      break;
    }
  return plan;
}

}  // namespace

std::uint32_t portable_material(Writer& w, std::uint32_t scene_material) {
  return w.materials.unlit(w.gltf_material(scene_material),
                           colour_holds_all(w.scene.materials[scene_material]));
}

Result<std::vector<MeshData>> portable_meshes(Writer& w, const Pieces& pieces, const Vec3d* frame,
                                              std::uint32_t max_vertices) {
  const scene::Object& first = w.scene.objects[pieces.front().first];
  LB_ASSIGN_OR_RETURN(const SourcePrimitive* front, w.sources.get(first.mesh, first.primitive));
  const CornerPlan plan = plan_without_colour(*front);
  std::vector<CornerStream> streams;
  for (const AttributeType& type : plan.types) streams.push_back({type, {}});
  streams.push_back({kColour, {}});
  std::vector<IndexRange> ranges;
  std::uint32_t corner = 0;
  for (const auto& [index, triangles] : pieces) {
    const scene::Object& object = w.scene.objects[index];
    LB_ASSIGN_OR_RETURN(const SourcePrimitive* source,
                        w.sources.get(object.mesh, object.primitive));
    const CornerCopier copier = frame != nullptr ? CornerCopier(plan, *source, object, *frame)
                                                 : CornerCopier(plan, *source);
    const SourceColour before = source_colour(*source);
    const scene::Material& material = w.scene.materials[object.material];
    const LitTriangles lit = subdivide(w, triangles, w.exposure);
    const std::uint32_t start = corner;
    for (std::size_t i = 0; i < lit.corners.size(); ++i) {
      // In its own frame a mirrored object keeps the winding that it came with.
      std::size_t at = i;
      if (frame == nullptr && object.mirrored && i % 3 != 0) at = i % 3 == 1 ? i + 1 : i - 1;
      const LightPoint& p = lit.corners[at];
      const auto vertices = w.source_vertices(*source, p.triangle);
      const double u = static_cast<double>(p.u), v = static_cast<double>(p.v);
      const std::array<double, 3> weights{1 - u - v, u, v};
      copier.mix(vertices, weights, streams);
      const Rgb light = colour_of(material, lit.irradiance[at], w.exposure);
      std::array<double, 4> own{};
      for (std::size_t c = 0; c < 4; ++c)
        for (std::size_t k = 0; k < 3; ++k) own[c] += weights[k] * before.at(vertices[k], c);
      // Viewers weigh what blends by its alpha.
      const bool blends = material.alpha_mode == scene::AlphaMode::kBlend;
      const double alpha = blends ? static_cast<double>(material.alpha) * own[3] : 1;
      const Rgb shine = lit.emission[at] * static_cast<float>(alpha > 0 ? w.exposure / alpha : 0);
      const std::array<double, 4> colour{
          static_cast<double>(light.r) * own[0] + static_cast<double>(shine.r),
          static_cast<double>(light.g) * own[1] + static_cast<double>(shine.g),
          static_cast<double>(light.b) * own[2] + static_cast<double>(shine.b), own[3]};
      for (const double value : colour)
        push_component(kColour, std::clamp(value, 0.0, 1.0), streams.back().bytes);
      ++corner;
    }
    ranges.push_back({index, start, corner - start});
  }
  return build_meshes(std::move(streams), std::move(ranges), max_vertices);
}

Result<Json> portable_primitives(Writer& w, std::uint32_t index) {
  const scene::Object& object = w.scene.objects[index];
  const Json& source =
      w.document.json.at("meshes").at(object.mesh).at("primitives").at(object.primitive);
  std::vector<std::uint32_t> lit, unlit;
  for (std::uint32_t k = 0; k < object.triangle_count; ++k) {
    const std::uint32_t t = object.first_triangle + k;
    (w.has_light(t) ? lit : unlit).push_back(t);
  }
  Json primitives = Json::array();
  LB_ASSIGN_OR_RETURN(const std::vector<MeshData> meshes,
                      portable_meshes(w, {{index, lit}}, nullptr, kNone));
  for (const MeshData& mesh : meshes) {
    Json primitive = add_primitive(w.binary, mesh.types, mesh.data, mesh.indices);
    primitive["material"] = portable_material(w, object.material);
    for (const char* key : {"extras", "extensions"})
      if (const Json* value = member(source, key)) primitive[key] = *value;
    erase_extension(primitive, "KHR_materials_variants");  // baked light is of one look
    primitives.push_back(std::move(primitive));
  }
  if (!unlit.empty()) {
    LB_ASSIGN_OR_RETURN(const SourcePrimitive* read, w.sources.get(object.mesh, object.primitive));
    std::vector<std::uint32_t> indices;
    for (const std::uint32_t t : unlit) {
      const std::uint32_t* c = read->corners.data() + 3 * std::size_t{w.scene.triangles[t].source};
      indices.insert(indices.end(), c, c + 3);
    }
    Json primitive = source;
    primitive.erase("mode");
    primitive["indices"] = w.binary.add_indices(indices);
    primitives.push_back(std::move(primitive));
  }
  return primitives;
}

}  // namespace lightbatch::scene_out
