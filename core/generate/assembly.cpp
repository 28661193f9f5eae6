#include "core/generate/assembly.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/generate/materials.h"
#include "core/gltf/glb_writer.h"
#include "core/math/aabb.h"

namespace lightbatch::generate {
namespace {

// glTF 2.0 numbers.
constexpr int kVertexTarget = 34962, kIndexTarget = 34963;
constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;

int shifted(int material, int variant) {
  return material >= kPaint && (material - kPaint) % kVariants == 0 ? material + variant % kVariants
                                                                    : material;
}

}  // namespace

std::size_t Assembly::add_accessor(std::span<const std::byte> bytes, int target,
                                   nlohmann::json accessor) {
  views_.push_back({{"buffer", 0},
                    {"byteOffset", binary_.size()},
                    {"byteLength", bytes.size()},
                    {"target", target}});
  binary_.insert(binary_.end(), bytes.begin(), bytes.end());
  binary_.resize((binary_.size() + 3) / 4 * 4);
  accessor["bufferView"] = views_.size() - 1;
  accessors_.push_back(std::move(accessor));
  return accessors_.size() - 1;
}

Assembly::ModelId Assembly::add_model(const Model& model) {
  Stored stored{model.name, model.triangles(), {}, {}};
  for (const Part& part : model.parts) {
    const Surface& surface = part.surface;
    Aabb box;
    for (const Vec3f& p : surface.positions) box.add(p);
    const auto count = surface.positions.size();
    const std::size_t positions =
        add_accessor(std::as_bytes(std::span(surface.positions)), kVertexTarget,
                     {{"componentType", kFloat},
                      {"type", "VEC3"},
                      {"count", count},
                      {"min", {box.lower.x, box.lower.y, box.lower.z}},
                      {"max", {box.upper.x, box.upper.y, box.upper.z}}});
    const std::size_t normals =
        add_accessor(std::as_bytes(std::span(surface.normals)), kVertexTarget,
                     {{"componentType", kFloat}, {"type", "VEC3"}, {"count", count}});
    nlohmann::json index_accessor = {{"type", "SCALAR"}, {"count", surface.indices.size()}};
    std::size_t indices = 0;
    if (count < std::numeric_limits<std::uint16_t>::max()) {
      std::vector<std::uint16_t> narrow(surface.indices.size());
      std::transform(surface.indices.begin(), surface.indices.end(), narrow.begin(),
                     [](std::uint32_t i) { return static_cast<std::uint16_t>(i); });
      index_accessor["componentType"] = kUnsignedShort;
      indices = add_accessor(std::as_bytes(std::span(narrow)), kIndexTarget, index_accessor);
    } else {
      index_accessor["componentType"] = kUnsignedInt;
      indices =
          add_accessor(std::as_bytes(std::span(surface.indices)), kIndexTarget, index_accessor);
    }
    stored.primitives.push_back({{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}},
                                 {"indices", indices},
                                 {"material", part.material}});
  }
  models_.push_back(std::move(stored));
  return models_.size() - 1;
}

std::size_t Assembly::mesh(ModelId model, int variant) {
  Stored& stored = models_[model];
  stored.variants.resize(kVariants, kRoot);
  std::size_t& made = stored.variants[static_cast<std::size_t>(variant % kVariants)];
  if (made != kRoot) return made;
  nlohmann::json primitives = nlohmann::json::array();
  for (nlohmann::json primitive : stored.primitives) {
    primitive["material"] = shifted(primitive["material"].get<int>(), variant);
    primitives.push_back(std::move(primitive));
  }
  meshes_.push_back({{"name", stored.name}, {"primitives", std::move(primitives)}});
  mesh_triangles_.push_back(stored.triangles);
  made = meshes_.size() - 1;
  return made;
}

Assembly::NodeId Assembly::add_node(NodeId parent, nlohmann::json node, const Vec3d& place,
                                    double yaw) {
  if (place != Vec3d{}) node["translation"] = {place.x, place.y, place.z};
  if (yaw != 0) node["rotation"] = {0.0, std::sin(yaw / 2), 0.0, std::cos(yaw / 2)};
  nodes_.push_back(std::move(node));
  children_.emplace_back();
  const NodeId id = nodes_.size() - 1;
  (parent == kRoot ? roots_ : children_[parent]).push_back(id);
  return id;
}

Assembly::NodeId Assembly::add_group(NodeId parent, const std::string& name, const Vec3d& place,
                                     double yaw) {
  return add_node(parent, {{"name", name}}, place, yaw);
}

void Assembly::add_mesh_node(NodeId parent, const std::string& name, std::size_t mesh,
                             const Vec3d& place, double yaw) {
  add_node(parent, {{"name", name}, {"mesh", mesh}}, place, yaw);
  drawn_triangles_ += mesh_triangles_[mesh];
}

void Assembly::add_point_light(NodeId parent, const std::string& name, const Vec3d& place) {
  if (lights_.empty()) {
    lights_.push_back({{"type", "point"},
                       {"name", "pendant"},
                       {"color", {1.0, 0.93, 0.82}},
                       {"intensity", 90.0}});
  }
  add_node(parent, {{"name", name}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}},
           place, 0);
}

Result<Bytes> Assembly::finish() {
  for (std::size_t i = 0; i < children_.size(); ++i) {
    if (!children_[i].empty()) nodes_[i]["children"] = children_[i];
  }
  nlohmann::json used = {"KHR_materials_emissive_strength"};
  nlohmann::json document = {
      {"asset", {{"version", "2.0"}, {"generator", "lightbatch office"}}},
      {"scene", 0},
      {"scenes", {{{"name", "office"}, {"nodes", roots_}}}},
      {"accessors", std::move(accessors_)},
      {"bufferViews", std::move(views_)},
      {"buffers", {{{"byteLength", binary_.size()}}}},
      {"materials", material_table()},
      {"meshes", std::move(meshes_)},
      {"nodes", std::move(nodes_)},
  };
  if (!lights_.empty()) {
    document["extensions"]["KHR_lights_punctual"]["lights"] = std::move(lights_);
    used.push_back("KHR_lights_punctual");
  }
  document["extensionsUsed"] = std::move(used);
  return gltf::write_glb(std::move(document), binary_);
}

}  // namespace lightbatch::generate
