#include "core/scene_in/moving_boxes.h"

#include <algorithm>
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

/// Joint matrices of a skin: world of the joint times its inverse bind matrix.
Result<std::vector<Affine>> joint_transforms(const gltf::Document& document, const NodeTree& tree,
                                             const Json& skin) {
  std::vector<Affine> joints;
  for (const Json& joint : skin["joints"]) joints.push_back(tree.world[joint.get<std::size_t>()]);
  const std::uint32_t accessor = gltf::index_field(skin, "inverseBindMatrices");
  if (accessor == kAbsent) return joints;
  std::vector<std::uint32_t> wanted(joints.size());
  std::iota(wanted.begin(), wanted.end(), 0u);
  LB_ASSIGN_OR_RETURN(const gltf::Values values, gltf::read_elements(document, accessor, wanted));
  for (std::size_t i = 0; i < joints.size(); ++i) {
    std::array<double, 16> m;
    for (std::size_t k = 0; k < 16; ++k) m[k] = static_cast<double>(values.data[16 * i + k]);
    joints[i] = joints[i] * Affine::from_column_major(m);
  }
  return joints;
}

/// A skinned vertex is a weighted mean of its images under the joints that move it: their box holds
/// it.
Result<Aabbd> skinned_box(const gltf::Document& document, const NodeTree& tree, const Json& skin,
                          const Json& attributes, const gltf::Values& positions) {
  LB_ASSIGN_OR_RETURN(const std::vector<Affine> joints, joint_transforms(document, tree, skin));
  Aabbd box;
  for (int set = 0;; ++set) {
    const std::string number = std::to_string(set);
    const std::uint32_t joint_accessor =
        gltf::index_field(attributes, ("JOINTS_" + number).c_str());
    const std::uint32_t weight_accessor =
        gltf::index_field(attributes, ("WEIGHTS_" + number).c_str());
    if (joint_accessor == kAbsent || weight_accessor == kAbsent) break;
    LB_ASSIGN_OR_RETURN(const gltf::Values indices, gltf::read_values(document, joint_accessor));
    LB_ASSIGN_OR_RETURN(const gltf::Values weights, gltf::read_values(document, weight_accessor));
    for (std::size_t i = 0; i < positions.count(); ++i) {
      for (std::size_t k = 4 * i; k < 4 * i + 4; ++k) {
        if (!(weights.data[k] > 0)) continue;
        const auto joint = static_cast<std::int64_t>(indices.data[k]);
        if (joint < 0 || joint >= static_cast<std::int64_t>(joints.size())) {
          return malformed(document.name + "#/accessors/" + std::to_string(joint_accessor),
                           "joint " + std::to_string(joint) + " is not one of the skin's");
        }
        box.add(joints[static_cast<std::size_t>(joint)].point(vector_at(positions, i)));
      }
    }
  }
  return box;
}

}  // namespace

Result<Aabbd> moving_box(const gltf::Document& document, const NodeTree& tree, std::uint32_t node,
                         const Json& primitive, const std::vector<Affine>& instances) {
  const Json& attributes = primitive["attributes"];
  const std::uint32_t accessor = gltf::index_field(attributes, "POSITION");
  if (accessor == kAbsent) return Aabbd{};
  LB_ASSIGN_OR_RETURN(const gltf::Values positions, gltf::read_values(document, accessor));
  const std::uint32_t skin = gltf::index_field(document.json["nodes"][node], "skin");
  if (skin != kAbsent) {
    return skinned_box(document, tree, document.json["skins"][skin], attributes, positions);
  }
  Aabbd local;
  for (std::size_t i = 0; i < positions.count(); ++i) local.add(vector_at(positions, i));
  for (const Json& target : gltf::list_field(primitive, "targets")) {
    const std::uint32_t offsets = gltf::index_field(target, "POSITION");
    if (offsets == kAbsent) continue;
    LB_ASSIGN_OR_RETURN(const gltf::Values moved, gltf::read_values(document, offsets));
    for (std::size_t i = 0; i < positions.count(); ++i) {
      local.add(vector_at(positions, i) + vector_at(moved, i));
    }
  }
  Aabbd box;
  for (const Affine& instance : instances) {
    const Affine world = tree.world[node] * instance;
    for (int corner = 0; corner < 8; ++corner) {
      box.add(world.point({(corner & 1) != 0 ? local.upper.x : local.lower.x,
                           (corner & 2) != 0 ? local.upper.y : local.lower.y,
                           (corner & 4) != 0 ? local.upper.z : local.lower.z}));
    }
  }
  return box;
}

}  // namespace lightbatch::scene_in
