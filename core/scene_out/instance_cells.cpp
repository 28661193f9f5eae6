#include "core/scene_out/instance_cells.h"

#include <array>
#include <cmath>

namespace lightbatch::scene_out {
namespace {

constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";

/// Unit quaternion of a rotation matrix with columns x, y, z (Shepperd 1978: the largest component
/// is found first, so that nothing small is divided by).
std::array<double, 4> quaternion(const Vec3d& x, const Vec3d& y, const Vec3d& z) {
  const double trace = x.x + y.y + z.z;
  std::array<double, 4> q;
  if (trace > 0) {
    const double s = 2 * std::sqrt(trace + 1);
    q = {(y.z - z.y) / s, (z.x - x.z) / s, (x.y - y.x) / s, 0.25 * s};
  } else if (x.x > y.y && x.x > z.z) {
    const double s = 2 * std::sqrt(1 + x.x - y.y - z.z);
    q = {0.25 * s, (x.y + y.x) / s, (z.x + x.z) / s, (y.z - z.y) / s};
  } else if (y.y > z.z) {
    const double s = 2 * std::sqrt(1 + y.y - x.x - z.z);
    q = {(x.y + y.x) / s, 0.25 * s, (y.z + z.y) / s, (z.x - x.z) / s};
  } else {
    const double s = 2 * std::sqrt(1 + z.z - x.x - y.y);
    q = {(z.x + x.z) / s, (y.z + z.y) / s, 0.25 * s, (x.y - y.x) / s};
  }
  return q;
}

}  // namespace

Result<Json> instance_node(Writer& w, const batches::InstanceCell& cell) {
  const Json& source = w.document.json.at("meshes").at(cell.mesh);
  std::uint32_t mesh = cell.mesh;
  if (cell.primitives.size() != source.at("primitives").size())
    mesh = w.part_of_mesh(cell.mesh, cell.primitives);
  const Vec3d frame = to_double(to_float(w.scene.origin + to_double(cell.box.centre())));
  std::vector<float> translation, rotation, scale;
  bool turned = false, scaled = false;
  for (const std::uint32_t o : cell.objects) {
    const Affine& m = w.scene.objects[o].to_world;
    const Vec3d s{length(m.x), length(m.y), length(m.z)};
    const auto q = quaternion(m.x / s.x, m.y / s.y, m.z / s.z);
    const Vec3f t = to_float(m.t - frame);
    const Vec3f s_float = to_float(s);
    translation.insert(translation.end(), {t.x, t.y, t.z});
    for (const double c : q) rotation.push_back(static_cast<float>(c));
    scale.insert(scale.end(), {s_float.x, s_float.y, s_float.z});
    turned = turned || rotation.back() != 1;
    scaled = scaled || s_float != Vec3f{1, 1, 1};
  }
  Json attributes{{"TRANSLATION", w.binary.add_instance_floats(translation, 3)}};
  if (turned) attributes["ROTATION"] = w.binary.add_instance_floats(rotation, 4);
  if (scaled) attributes["SCALE"] = w.binary.add_instance_floats(scale, 3);
  declare_extension(w.root, "extensionsUsed", kInstancing);
  // Without it a reader would draw one instance of many.
  declare_extension(w.root, "extensionsRequired", kInstancing);
  Json node{{"mesh", mesh}, {"translation", {frame.x, frame.y, frame.z}}};
  node["extensions"][kInstancing]["attributes"] = std::move(attributes);
  Json names = Json::array();
  for (const std::uint32_t o : cell.objects) names.push_back(w.scene.objects[o].node);
  node["extras"]["lightbatch"]["nodes"] = std::move(names);
  return node;
}

}  // namespace lightbatch::scene_out
