#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "core/scene_out/colours.h"
#include "core/scene_out/json_access.h"
#include "core/scene_out/materials.h"
#include "core/scene_out/references.h"
#include "core/scene_out/source_mesh.h"
#include "core/scene_out/write_scene.h"

namespace lightbatch::scene_out {
namespace {

// Node extensions that say nothing of how the node's mesh is drawn.
constexpr const char* kHarmless[] = {
    "KHR_lights_punctual", "EXT_mesh_gpu_instancing", "KHR_xmp",
    "KHR_xmp_json_ld",     "OMI_physics_body",        "MOZ_hubs_components"};

bool is_harmless(const std::string& name) {
  for (const char* harmless : kHarmless)
    if (name == harmless) return true;
  return false;
}

/// Whether physics may move the node: a body whose motion is not static.
bool is_moving_body(const Json& node) {
  const Json* body = extension(node, "OMI_physics_body");
  if (body == nullptr) return false;
  // Older drafts have the type in the body itself.
  const Json* motion = member(*body, "motion");
  const Json* type = member(motion != nullptr ? *motion : *body, "type");
  if (type == nullptr) return motion != nullptr;
  return *type != "static" && *type != "trigger";
}

/// Nodes reached from scenes other than the default one.
std::set<std::uint32_t> nodes_of_other_scenes(const Json& root) {
  std::set<std::uint32_t> reached;
  const std::uint32_t named = index_at(root, "scene");
  const std::uint32_t main = named == kNone ? 0 : named;
  std::vector<std::uint32_t> stack;
  const auto push = [&](const Json& json, const char* key) {
    if (const Json* list = member(json, key))
      for (const Json& n : *list) stack.push_back(n.get<std::uint32_t>());
  };
  for (std::uint32_t s = 0; s < count_of(root, "scenes"); ++s)
    if (s != main) push(root.at("scenes").at(s), "nodes");
  while (!stack.empty()) {
    const std::uint32_t node = stack.back();
    stack.pop_back();
    if (reached.insert(node).second) push(root.at("nodes").at(node), "children");
  }
  return reached;
}

/// Why a node's objects must stay in it, of itself or of a node above.
std::vector<std::string> reasons_of_nodes(const Json& root) {
  const std::uint32_t count = count_of(root, "nodes");
  std::vector<std::string> reason(count);
  std::vector<std::uint32_t> below;
  const auto other = nodes_of_other_scenes(root);
  for (std::uint32_t n = 0; n < count; ++n) {
    const Json& node = root.at("nodes").at(n);
    if (other.contains(n)) reason[n] = "also in another scene of the file";
    if (const Json* extensions = member(node, "extensions"); extensions != nullptr)
      for (const auto& [name, value] : extensions->items())
        if (!is_harmless(name)) reason[n] = "node extension " + name;
    if (is_moving_body(node)) reason[n] = "moved by physics";
    if (!reason[n].empty()) below.push_back(n);
  }
  const auto keep = [&](std::uint64_t n, const char* why) {
    if (n >= count || !reason[n].empty()) return;
    reason[n] = why;
    below.push_back(static_cast<std::uint32_t>(n));
  };
  if (const Json* skins = member(root, "skins"))
    for (const Json& skin : *skins)
      for (const Json& joint : skin.at("joints"))
        keep(joint.get<std::uint64_t>(), "joint of a skin");
  const Pins pins = find_pins(root);
  for (std::uint32_t n = 0; n < count; ++n)
    if (pins.any_node || pins.nodes.contains(n)) keep(n, "named by a pointer of an extension");
  while (!below.empty()) {
    const std::uint32_t n = below.back();
    below.pop_back();
    const Json* children = member(root.at("nodes").at(n), "children");
    if (children == nullptr) continue;
    for (const Json& child : *children) {
      const auto c = child.get<std::uint32_t>();
      if (!reason[c].empty()) continue;
      reason[c] = reason[n];
      below.push_back(c);
    }
  }
  return reason;
}

/// An attribute of a node's GPU instances that is no transform, or empty.
std::string own_attribute(const Json& node) {
  const Json* instancing = extension(node, "EXT_mesh_gpu_instancing");
  const Json* attributes = instancing == nullptr ? nullptr : member(*instancing, "attributes");
  if (attributes != nullptr)
    for (const auto& [name, accessor] : attributes->items())
      if (property_of_attribute(name) == nullptr) return name;
  return {};
}

bool is_scaled(const Affine& m) {
  constexpr double kRounding = 1e-5;
  for (const Vec3d& axis : {m.x, m.y, m.z})
    if (std::abs(length(axis) - 1) > kRounding) return true;
  return false;
}

bool all_charted(const atlas::Layout& layout, const scene::Object& object) {
  for (std::uint32_t k = 0; k < object.triangle_count; ++k)
    if (layout.chart_of[object.first_triangle + k] == kNone) return false;
  return true;
}

}  // namespace

std::vector<batches::ObjectTraits> describe_objects(const gltf::Document& document,
                                                    const scene::Scene& scene,
                                                    const atlas::Layout* layout) {
  const Json& root = document.json;
  const std::vector<std::string> reasons = reasons_of_nodes(root);
  std::vector<batches::ObjectTraits> traits(scene.objects.size());
  const std::vector<std::uint32_t> classes = material_classes(root, scene, layout != nullptr);
  std::map<std::string, std::uint32_t> layouts;
  for (std::uint32_t o = 0; o < scene.objects.size(); ++o) {
    const scene::Object& object = scene.objects[o];
    const Json& primitive = root.at("meshes").at(object.mesh).at("primitives").at(object.primitive);
    const bool lit = layout != nullptr && all_charted(*layout, object);
    const Json* variants = extension(primitive, "KHR_materials_variants");
    const bool own_uv1 =
        lit && variants == nullptr && !uses_uv_set(root, index_at(primitive, "material"), 1);
    traits[o].material_class = classes[object.material];
    std::string signature;
    std::uint32_t bytes = 0;
    for (const AttributeType& type : attribute_types(root, primitive)) {
      if (type.name == "TEXCOORD_1" && own_uv1) continue;
      if (type.name == "COLOR_0") traits[o].material_class = kNone;
      const bool position = type.name == "POSITION";
      signature += type.name + ' ' +
                   (position ? ""
                             : std::to_string(type.component_type) + type.type +
                                   (type.normalized ? 'n' : ' ')) +
                   ';';
      bytes += static_cast<std::uint32_t>(position ? 12 : (type.bytes() + 3) / 4 * 4);
    }
    if (variants != nullptr) signature += variants->dump();
    if (lit) bytes += 8;
    traits[o].layout =
        layouts.try_emplace(signature, static_cast<std::uint32_t>(layouts.size())).first->second;
    traits[o].vertex_bytes = bytes;
    traits[o].keep = reasons[object.node];
    if (object.instance != kNone)
      if (const std::string name = own_attribute(root.at("nodes").at(object.node)); !name.empty())
        traits[o].keep = "attribute " + name + " of GPU instances";
    if (const Json* extensions = member(root.at("meshes").at(object.mesh), "extensions"))
      for (const auto& [name, value] : extensions->items())
        traits[o].keep = "mesh extension " + name;
    if (is_scaled(object.to_world) && is_thick(root, primitive))
      traits[o].keep = "thickness of its volume is scaled by its node";
    if (const Json* extensions = member(primitive, "extensions"))
      for (const auto& [name, value] : extensions->items()) {
        if (name != "KHR_materials_variants")
          traits[o].keep = "primitive extension " + name;
        else
          traits[o].material_class = kNone;
      }
  }
  return traits;
}

std::vector<bool> opening_objects(const gltf::Document& document, const scene::Scene& scene) {
  const Json& root = document.json;
  const auto hides = [&](std::uint32_t material) {
    if (material == kNone) return true;
    const Json& m = root.at("materials").at(material);
    return m.value("alphaMode", "OPAQUE") == "OPAQUE" &&
           extension(m, "KHR_materials_transmission") == nullptr &&
           extension(m, "KHR_materials_diffuse_transmission") == nullptr;
  };
  const auto both_sides = [&](std::uint32_t material) {
    return material != kNone && root.at("materials").at(material).value("doubleSided", false);
  };
  std::vector<bool> opens(scene.objects.size(), false);
  for (std::uint32_t o = 0; o < opens.size(); ++o) {
    const scene::Object& object = scene.objects[o];
    const Json& primitive = root.at("meshes").at(object.mesh).at("primitives").at(object.primitive);
    const Json* variants = extension(primitive, "KHR_materials_variants");
    const Json* mappings = variants == nullptr ? nullptr : member(*variants, "mappings");
    if (mappings == nullptr) continue;
    const std::uint32_t shown = index_at(primitive, "material");
    for (const Json& mapping : *mappings) {
      const std::uint32_t material = index_at(mapping, "material");
      if (!hides(material) || both_sides(material) != both_sides(shown)) opens[o] = true;
    }
  }
  return opens;
}

}  // namespace lightbatch::scene_out
