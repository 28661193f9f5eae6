#include "core/scene_in/moving_boxes.h"

#include <array>
#include <numeric>

#include "core/gltf/accessor.h"
#include "core/gltf/fields.h"

namespace lightbatch::scene_in {
namespace {

using gltf::Json;
using gltf::kAbsent;

Vec3d vector_at(const gltf::Values& values, std::size_t i) {
  const float* v = values.data.data() + 3 * i;
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

Aabbd moved(const Aabbd& box, const Affine& by) {
  Aabbd result;
  for (unsigned k = 0; k < 8; ++k) result.add(by.point(box.corner(k)));
  return result;
}

/// Where each vertex may be: its position, and what any mix of morph targets makes of it.
Result<std::vector<Aabbd>> vertex_boxes(const gltf::Document& document, const Json& primitive,
                                        std::uint32_t accessor) {
  LB_ASSIGN_OR_RETURN(const gltf::Values positions, gltf::read_values(document, accessor));
  std::vector<Aabbd> boxes(positions.count());
  for (std::size_t i = 0; i < boxes.size(); ++i) boxes[i].add(vector_at(positions, i));
  for (const Json& target : gltf::list_field(primitive, "targets")) {
    const std::uint32_t offsets = gltf::index_field(target, "POSITION");
    if (offsets == kAbsent) continue;
    LB_ASSIGN_OR_RETURN(const gltf::Values values, gltf::read_values(document, offsets));
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const Vec3d by = vector_at(values, i);
      const Vec3d lower = boxes[i].lower + by, upper = boxes[i].upper + by;
      boxes[i].add(lower);
      boxes[i].add(upper);
    }
  }
  return boxes;
}

/// Inverse bind matrices of a skin.
Result<std::vector<Affine>> inverse_binds(const gltf::Document& document, const Json& skin) {
  std::vector<Affine> binds(skin["joints"].size());
  const std::uint32_t accessor = gltf::index_field(skin, "inverseBindMatrices");
  if (accessor == kAbsent) return binds;
  std::vector<std::uint32_t> wanted(binds.size());
  std::iota(wanted.begin(), wanted.end(), 0u);
  LB_ASSIGN_OR_RETURN(const gltf::Values values, gltf::read_elements(document, accessor, wanted));
  for (std::size_t i = 0; i < binds.size(); ++i) {
    std::array<double, 16> m;
    for (std::size_t k = 0; k < 16; ++k) m[k] = static_cast<double>(values.data[16 * i + k]);
    binds[i] = Affine::from_column_major(m);
  }
  return binds;
}

Result<std::vector<CarriedBox>> carried_by_joints(const gltf::Document& document, const Json& skin,
                                                  const Json& attributes,
                                                  const std::vector<Aabbd>& vertices) {
  LB_ASSIGN_OR_RETURN(const std::vector<Affine> binds, inverse_binds(document, skin));
  std::vector<CarriedBox> joints(binds.size());
  for (std::size_t j = 0; j < joints.size(); ++j) {
    joints[j].node = skin["joints"][j].get<std::uint32_t>();
  }
  for (int set = 0;; ++set) {
    const std::string number = std::to_string(set);
    const std::uint32_t joint_accessor =
        gltf::index_field(attributes, ("JOINTS_" + number).c_str());
    const std::uint32_t weight_accessor =
        gltf::index_field(attributes, ("WEIGHTS_" + number).c_str());
    if (joint_accessor == kAbsent || weight_accessor == kAbsent) break;
    LB_ASSIGN_OR_RETURN(const gltf::Values indices, gltf::read_values(document, joint_accessor));
    LB_ASSIGN_OR_RETURN(const gltf::Values weights, gltf::read_values(document, weight_accessor));
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      for (std::size_t k = 4 * i; k < 4 * i + 4; ++k) {
        if (!(weights.data[k] > 0)) continue;
        const auto joint = static_cast<std::int64_t>(indices.data[k]);
        if (joint < 0 || joint >= static_cast<std::int64_t>(joints.size())) {
          return malformed(document.name + "#/accessors/" + std::to_string(joint_accessor),
                           "joint " + std::to_string(joint) + " is not one of the skin's");
        }
        const auto j = static_cast<std::size_t>(joint);
        joints[j].box.add(moved(vertices[i], binds[j]));
      }
    }
  }
  std::erase_if(joints, [](const CarriedBox& joint) { return joint.box.is_empty(); });
  return joints;
}

}  // namespace

Result<std::vector<CarriedBox>> carried_boxes(const gltf::Document& document, std::uint32_t node,
                                              const Json& primitive,
                                              const std::vector<Affine>& instances) {
  const Json& attributes = primitive["attributes"];
  const std::uint32_t accessor = gltf::index_field(attributes, "POSITION");
  if (accessor == kAbsent) return std::vector<CarriedBox>{};
  LB_ASSIGN_OR_RETURN(const std::vector<Aabbd> vertices,
                      vertex_boxes(document, primitive, accessor));
  const std::uint32_t skin = gltf::index_field(document.json["nodes"][node], "skin");
  if (skin != kAbsent) {
    return carried_by_joints(document, document.json["skins"][skin], attributes, vertices);
  }
  Aabbd local;
  for (const Aabbd& vertex : vertices) local.add(vertex);
  std::vector<CarriedBox> carried;
  if (local.is_empty()) return carried;
  for (const Affine& instance : instances) carried.push_back({node, instance, local});
  return carried;
}

Aabbd world_box(const std::vector<CarriedBox>& carried, const std::vector<Affine>& world) {
  Aabbd box;
  for (const CarriedBox& c : carried) box.add(moved(c.box, world[c.node] * c.to_node));
  return box;
}

}  // namespace lightbatch::scene_in
