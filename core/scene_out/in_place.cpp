#include "core/scene_out/in_place.h"

#include <algorithm>
#include <map>
#include <span>

#include "core/gltf/accessor.h"
#include "core/scene_out/corners.h"
#include "core/scene_out/json_access.h"
#include "core/scene_out/lit_objects.h"
#include "core/scene_out/portable.h"

namespace lightbatch::scene_out {
namespace {

constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";

/// Objects that stay, by node and primitive; several where a node has GPU instances.
struct NodeObjects {
  std::map<std::uint32_t, std::vector<std::uint32_t>> stay;   // primitive -> objects
  std::map<std::uint32_t, std::vector<std::uint32_t>> taken;  // into batches or cells
};

std::vector<bool> objects_that_stay(const scene::Scene& scene, const batches::BatchPlan* plan) {
  std::vector<bool> stay(scene.objects.size(), plan == nullptr);
  if (plan != nullptr)
    for (const batches::LeftAlone& alone : plan->left_alone) stay[alone.object] = true;
  return stay;
}

bool has_light(const Writer& w, std::uint32_t object) {
  const scene::Object& o = w.scene.objects[object];
  for (std::uint32_t k = 0; k < o.triangle_count; ++k)
    if (w.has_light(o.first_triangle + k)) return true;
  return false;
}

/// A component as JSON: whole numbers stay whole, however large.
Json component_json(const AttributeType& type, const std::byte* element, std::size_t i) {
  const double value = component(type, element, i);
  if (type.component_type != 5126 && !type.normalized) return static_cast<std::int64_t>(value);
  return value;
}

/// Child nodes for GPU instances that have light of their own. What else instances have goes into
/// extras.
Status add_instance_children(Writer& w, Json& node, const Json& instancing,
                             const std::map<std::uint32_t, Json>& primitives_of_instance,
                             const Json& mesh) {
  const std::vector<AttributeType> types = attribute_types(w.document.json, instancing);
  std::vector<Bytes> data;
  for (const AttributeType& type : types) {
    LB_ASSIGN_OR_RETURN(
        Bytes bytes,
        gltf::read_packed(w.document, index_at(instancing.at("attributes"), type.name)));
    data.push_back(std::move(bytes));
  }
  for (const auto& [instance, primitives] : primitives_of_instance) {
    Json copy = mesh;
    copy["primitives"] = primitives;
    Json child{{"mesh", append(w.root, "meshes", std::move(copy))}};
    for (std::size_t a = 0; a < types.size(); ++a) {
      const AttributeType& type = types[a];
      const std::span element = std::span(data[a]).subspan(instance * type.bytes(), type.bytes());
      Json list = Json::array();
      for (std::size_t c = 0; c < static_cast<std::size_t>(type.components); ++c)
        list.push_back(component_json(type, element.data(), c));
      if (const char* property = property_of_attribute(type.name))
        child[property] = std::move(list);
      else
        child["extras"]["lightbatch"]["attributes"][type.name] = std::move(list);
    }
    const std::uint32_t index = append(w.root, "nodes", std::move(child));
    node["children"].push_back(index);
  }
  return {};
}

}  // namespace

Status rewrite_nodes(Writer& w, const batches::BatchPlan* plan) {
  const std::vector<bool> stay = objects_that_stay(w.scene, plan);
  std::map<std::uint32_t, NodeObjects> nodes;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> lit_sets;
  for (std::uint32_t o = 0; o < w.scene.objects.size(); ++o) {
    const scene::Object& object = w.scene.objects[o];
    NodeObjects& entry = nodes[object.node];
    if (object.triangle_count == 0) continue;  // other GPU instances decide for this one
    (stay[o] ? entry.stay : entry.taken)[object.primitive].push_back(o);
    if (stay[o] && has_light(w, o)) lit_sets[{object.mesh, object.primitive}].push_back(o);
  }
  std::map<std::uint32_t, Json> lit;  // object -> its glTF primitives
  for (const auto& [source, objects] : lit_sets) {
    if (w.portable()) {
      for (const std::uint32_t o : objects) {
        LB_ASSIGN_OR_RETURN(lit[o], portable_primitives(w, o));
      }
      continue;
    }
    LB_ASSIGN_OR_RETURN(std::vector<Json> primitives, lit_primitives(w, objects));
    for (std::size_t i = 0; i < objects.size(); ++i) lit[objects[i]] = std::move(primitives[i]);
  }

  for (const auto& [index, objects] : nodes) {
    // Copied, and put back at the end: children are appended to the same list of nodes.
    Json node = w.root["nodes"][index];
    const std::uint32_t mesh_index = index_at(node, "mesh");
    const Json& mesh = w.document.json.at("meshes").at(mesh_index);
    const auto count = static_cast<std::uint32_t>(mesh.at("primitives").size());
    const Json* instancing = extension(w.document.json.at("nodes").at(index), kInstancing);
    std::vector<std::uint32_t> as_is;
    Json fresh = Json::array();
    std::map<std::uint32_t, Json> of_instance;
    for (std::uint32_t p = 0; p < count; ++p) {
      const auto staying = objects.stay.find(p);
      if (staying == objects.stay.end()) {
        if (!objects.taken.contains(p)) as_is.push_back(p);  // lines, points, nothing with an area
        continue;
      }
      const bool any_lit = std::any_of(staying->second.begin(), staying->second.end(),
                                       [&](std::uint32_t o) { return lit.contains(o); });
      if (!any_lit) {
        as_is.push_back(p);
        continue;
      }
      for (const std::uint32_t o : staying->second) {
        Json list = Json::array({mesh.at("primitives").at(p)});
        if (const auto it = lit.find(o); it != lit.end()) list = it->second;
        const std::uint32_t instance = w.scene.objects[o].instance;
        Json& into = instance == kNone ? fresh : of_instance[instance];
        if (!into.is_array()) into = Json::array();
        for (Json& primitive : list) into.push_back(std::move(primitive));
      }
    }
    if (as_is.size() == count) continue;
    if (!of_instance.empty())
      LB_RETURN_IF_ERROR(add_instance_children(w, node, *instancing, of_instance, mesh));
    if (as_is.empty() && fresh.empty()) {
      node.erase("mesh");
      erase_extension(node, kInstancing);
    } else if (fresh.empty()) {
      node["mesh"] = w.part_of_mesh(mesh_index, as_is);
    } else {
      Json copy = mesh;
      for (const std::uint32_t p : as_is) fresh.push_back(mesh.at("primitives").at(p));
      copy["primitives"] = std::move(fresh);
      node["mesh"] = append(w.root, "meshes", std::move(copy));
    }
    w.root["nodes"][index] = std::move(node);
  }
  return {};
}

}  // namespace lightbatch::scene_out
