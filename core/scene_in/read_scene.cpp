#include "core/scene_in/read_scene.h"

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/base/parallel.h"
#include "core/gltf/fields.h"
#include "core/scene_in/animation.h"
#include "core/scene_in/lights.h"
#include "core/scene_in/materials.h"
#include "core/scene_in/model.h"
#include "core/scene_in/moving_boxes.h"
#include "core/scene_in/nodes.h"
#include "core/scene_in/place.h"
#include "core/scene_in/primitive.h"

namespace lightbatch::scene_in {
namespace {

using gltf::Json;
using gltf::kAbsent;

class SceneReader {
 public:
  SceneReader(const gltf::Document& document, const gltf::ReadLimits& limits)
      : document_(document), json_(document.json), limits_(limits) {}

  Result<scene::Scene> read() {
    if (gltf::list_field(json_, "scenes").empty()) {
      scene_.warnings.push_back(document_.name +
                                ": the file has no scene; there is nothing to light");
    }
    LB_ASSIGN_OR_RETURN(tree_, read_nodes(document_));
    scene_.counts.zero_scale_nodes = tree_.zero_scale;
    LB_ASSIGN_OR_RETURN(const tinygltf::Model model, read_model(document_));
    LB_RETURN_IF_ERROR(collect());
    LB_RETURN_IF_ERROR(sweep_moving());
    read_materials(model);
    LB_RETURN_IF_ERROR(read_primitives());
    const auto [uv0, uv1] = uv_needed();
    LB_RETURN_IF_ERROR(place_objects(placements_, primitives_, uv0, uv1, document_.name, scene_));
    LB_RETURN_IF_ERROR(read_lights(document_, model, tree_, scene_));
    return std::move(scene_);
  }

 private:
  /// Why a mesh under this node cannot be part of the static scene; "" when it can.
  std::string moving(const PlacedNode& placed, const Json& primitive) const {
    if (json_["nodes"][placed.node].contains("skin")) return "skinned";
    if (primitive.contains("targets")) return "morph targets";
    if (placed.animated) return "animated";
    return {};
  }

  std::string name_of(std::uint32_t node, const Json& mesh) const {
    std::string name = gltf::text_field(json_["nodes"][node], "name");
    if (name.empty()) name = gltf::text_field(mesh, "name");
    return name.empty() ? "node " + std::to_string(node) : name;
  }

  /// Walks the scene's meshes: what is lit becomes a placement, the rest is listed.
  Status collect() {
    for (const PlacedNode& placed : tree_.placed) {
      const Json& node = json_["nodes"][placed.node];
      const std::uint32_t mesh = gltf::index_field(node, "mesh");
      if (mesh == kAbsent) continue;
      LB_RETURN_IF_ERROR(spend_objects(instance_count(document_, placed.node), placed.node));
      LB_ASSIGN_OR_RETURN(const std::vector<Affine> instances,
                          read_instances(document_, placed.node));
      const bool instanced = gltf::extension_of(node, "EXT_mesh_gpu_instancing") != nullptr;
      const Json& primitives = json_["meshes"][mesh]["primitives"];
      for (std::uint32_t p = 0; p < primitives.size(); ++p) {
        std::string reason = placed.hidden ? "hidden" : undrawable(primitives[p]);
        if (reason.empty()) {
          reason = moving(placed, primitives[p]);
          if (!reason.empty()) {
            LB_RETURN_IF_ERROR(spend_moving(primitives[p], placed.node));
            LB_RETURN_IF_ERROR(add_moving(placed.node, mesh, primitives[p], instances));
          }
        }
        if (!reason.empty()) {
          scene_.skipped.push_back({placed.node, mesh, p, reason});
          continue;
        }
        LB_RETURN_IF_ERROR(spend_triangles(triangle_count(document_, primitives[p]),
                                           instances.size(), placed.node));
        for (std::size_t i = 0; i < instances.size(); ++i) {
          place(placed.node, mesh, p, instanced ? static_cast<std::uint32_t>(i) : kAbsent,
                tree_.world[placed.node] * instances[i]);
        }
      }
    }
    return {};
  }

  Status add_moving(std::uint32_t node, std::uint32_t mesh, const Json& primitive,
                    const std::vector<Affine>& instances) {
    LB_ASSIGN_OR_RETURN(std::vector<CarriedBox> carried,
                        carried_boxes(document_, node, primitive, instances));
    scene::MovingMesh moving;
    moving.name = name_of(node, json_["meshes"][mesh]);
    moving.node = node;
    moving.rest = moving.swept = world_box(carried, tree_.world);
    if (moving.rest.is_empty()) return {};
    scene_.moving.push_back(std::move(moving));
    carried_.push_back(std::move(carried));
    return {};
  }

  /// Follows the animations.
  Status sweep_moving() {
    if (scene_.moving.empty()) return {};
    std::size_t boxes = 0;
    for (const auto& carried : carried_) boxes += carried.size();
    LB_RETURN_IF_ERROR(for_each_pose(
        document_, tree_, boxes,
        [&](const std::vector<Affine>& world) {
          parallel_for(scene_.moving.size(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
              scene_.moving[i].swept.add(world_box(carried_[i], world));
            }
          });
        },
        scene_.warnings));
    for (const scene::MovingMesh& moving : scene_.moving) {
      const double farthest = std::max(length(moving.swept.lower), length(moving.swept.upper));
      if (!(farthest <= kLargestScene)) {
        return malformed(document_.name + "#/nodes/" + std::to_string(moving.node),
                         "the node moves farther than 1e15 metres or to no finite place");
      }
    }
    return {};
  }

  Status spend_objects(std::uint64_t count, std::uint32_t node) {
    objects_ += count;
    if (objects_ <= limits_.nodes) return {};
    return over_budget(document_.name + "#/nodes/" + std::to_string(node),
                       "the scene has more than " + std::to_string(limits_.nodes) + " instances");
  }

  /// Boxes of what moves are found anew for each node: the work is counted, since nodes may share a
  /// large mesh any number of times.
  Status spend_moving(const Json& primitive, std::uint32_t node) {
    const std::uint32_t accessor = gltf::index_field(primitive["attributes"], "POSITION");
    const std::uint32_t skin = gltf::index_field(json_["nodes"][node], "skin");
    const std::uint64_t passes =
        2 + gltf::list_field(primitive, "targets").size() + 2 * primitive["attributes"].size();
    vertices_ += passes * json_["accessors"][accessor]["count"].get<std::uint64_t>();
    if (skin != kAbsent) vertices_ += json_["skins"][skin]["joints"].size();
    if (vertices_ <= kVerticesPerTriangle * limits_.triangles) return {};
    return over_budget(document_.name + "#/nodes/" + std::to_string(node),
                       "too many vertices move");
  }

  Status spend_triangles(std::uint64_t count, std::uint64_t instances, std::uint32_t node) {
    const std::uint64_t left = limits_.triangles - triangles_;
    if (count > 0 && instances > left / count) {
      return over_budget(document_.name + "#/nodes/" + std::to_string(node),
                         "the scene has more than " + std::to_string(limits_.triangles) +
                             " triangles when instances are expanded");
    }
    triangles_ += count * instances;
    return {};
  }

  void place(std::uint32_t node, std::uint32_t mesh, std::uint32_t primitive,
             std::uint32_t instance, const Affine& world) {
    const auto [known, added] = keys_.try_emplace({mesh, primitive}, keys_.size());
    Placement placement;
    placement.primitive = known->second;
    scene::Object& object = placement.object;
    object.name = name_of(node, json_["meshes"][mesh]);
    object.node = node;
    object.mesh = mesh;
    object.primitive = primitive;
    object.instance = instance;
    object.to_world = world;
    object.mirrored = world.determinant() < 0;
    placements_.push_back(std::move(placement));
  }

  /// Materials that placements use, ascending, the default one last.
  void read_materials(const tinygltf::Model& model) {
    const auto material_of = [this](const scene::Object& object) {
      return gltf::index_field(json_["meshes"][object.mesh]["primitives"][object.primitive],
                               "material");
    };
    std::map<std::uint32_t, std::uint32_t> numbers;
    for (const Placement& placement : placements_)
      numbers.emplace(material_of(placement.object), 0);
    TextureReader textures(document_, model, limits_);
    for (auto& [index, number] : numbers) {
      number = static_cast<std::uint32_t>(scene_.materials.size());
      scene_.materials.push_back(
          read_material(model, index, document_.name, textures, scene_.warnings));
      const scene::Material& material = scene_.materials.back();
      if ((1 - material.metallic) * material.base_color.max() > kLargestReflectance) {
        ++scene_.counts.clamped_reflectance;
      }
    }
    textures.decode(scene_);
    for (Placement& placement : placements_) {
      placement.object.material = numbers[material_of(placement.object)];
    }
  }

  static PrimitiveNeeds needs_of(const scene::Material& material) {
    PrimitiveNeeds needs;
    for (const scene::TextureSlot* slot : material.texture_slots()) {
      if (slot->present()) (slot->uv_set == 0 ? needs.uv0 : needs.uv1) = true;
    }
    return needs;
  }

  std::pair<bool, bool> uv_needed() const {
    PrimitiveNeeds all;
    for (const scene::Material& material : scene_.materials) {
      const PrimitiveNeeds needs = needs_of(material);
      all.uv0 = all.uv0 || needs.uv0;
      all.uv1 = all.uv1 || needs.uv1;
    }
    return {all.uv0, all.uv1};
  }

  /// Each primitive once, however often it is placed.
  Status read_primitives() {
    primitives_.resize(keys_.size());
    std::vector<const Json*> sources(keys_.size());
    std::vector<PrimitiveNeeds> needs(keys_.size());
    for (const auto& [key, index] : keys_) {
      sources[index] = &json_["meshes"][key.first]["primitives"][key.second];
    }
    for (const Placement& placement : placements_) {
      needs[placement.primitive] = needs_of(scene_.materials[placement.object.material]);
    }
    std::vector<Status> statuses(keys_.size());
    parallel_for(keys_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        Result<Primitive> primitive = read_primitive(document_, *sources[i], needs[i]);
        if (primitive.ok()) {
          primitives_[i] = std::move(primitive).value();
        } else {
          statuses[i] = primitive.status();
        }
      }
    });
    for (const Status& status : statuses) LB_RETURN_IF_ERROR(status);
    return {};
  }

  static constexpr float kLargestReflectance = 0.999f;
  static constexpr std::uint64_t kVerticesPerTriangle = 8;

  const gltf::Document& document_;
  const Json& json_;
  const gltf::ReadLimits& limits_;
  scene::Scene scene_;
  NodeTree tree_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> keys_;  // (mesh, primitive)
  std::vector<std::vector<CarriedBox>> carried_;                         // of scene_.moving
  std::vector<Placement> placements_;
  std::vector<Primitive> primitives_;
  std::uint64_t objects_ = 0;
  std::uint64_t triangles_ = 0;
  std::uint64_t vertices_ = 0;
};

}  // namespace

Result<scene::Scene> read_scene(const gltf::Document& document, const gltf::ReadLimits& limits) {
  return SceneReader(document, limits).read();
}

}  // namespace lightbatch::scene_in
