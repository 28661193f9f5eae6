#include "core/scene_out/instance_cells.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/scene_out/colours.h"
#include "core/scene_out/gather.h"
#include "core/scene_out/range_json.h"

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

/// Rotation and scale of a plain placement.
struct Turn {
  std::array<double, 4> rotation;
  Vec3d scale;
};
Turn turn_of(const Affine& m) {
  const Vec3d s{length(m.x), length(m.y), length(m.z)};
  return {quaternion(m.x / s.x, m.y / s.y, m.z / s.z), s};
}

Json json_of(const Vec3d& v) { return {v.x, v.y, v.z}; }

/// Of all placements of a part.
double largest_scale(const scene::Scene& scene, const batches::BatchPlan& plan,
                     std::uint32_t part) {
  double largest = 0;
  for (const batches::InstanceCell& cell : plan.cells) {
    if (cell.part != part) continue;
    for (const std::uint32_t o : cell.objects) {
      const Affine& m = scene.objects[o].to_world;
      largest = std::max({largest, length(m.x), length(m.y), length(m.z)});
    }
  }
  return largest;
}

/// Positions of a part stay as the source has them where all its primitives have them so.
Status keep_positions(Writer& w, const batches::InstancePart& part, CornerPlan& plan) {
  const AttributeType* kept = nullptr;
  for (const batches::Piece& piece : part.pieces) {
    const scene::Object& o = w.scene.objects[piece.object];
    LB_ASSIGN_OR_RETURN(const SourcePrimitive* source, w.sources.get(o.mesh, o.primitive));
    for (const AttributeType& type : source->types) {
      if (type.name != "POSITION") continue;
      if (kept != nullptr && !(type == *kept)) return {};
      kept = &type;
    }
  }
  for (AttributeType& type : plan.types)
    if (type.name == "POSITION" && kept != nullptr) type = *kept;
  return {};
}

}  // namespace

Result<InstanceNodes::PartMesh> InstanceNodes::mesh_of(const batches::BatchPlan& plan,
                                                       std::uint32_t index) {
  const batches::InstancePart& part = plan.parts[index];
  const Json& source = w_.document.json.at("meshes").at(part.mesh);
  const scene::Object& first = w_.scene.objects[part.pieces.front().object];
  LB_ASSIGN_OR_RETURN(const SourcePrimitive* front, w_.sources.get(first.mesh, first.primitive));
  const Json& model = source.at("primitives").at(first.primitive);
  const Quantizer::PartGrid grid =
      model.contains("extras") ? Quantizer::PartGrid{} : quantizer_.part_grid(part);
  if (part.whole && !part.coloured && front->vertex_count() <= plan.max_vertices &&
      !(grid.step > 0)) {
    if (source.at("primitives").size() == 1) return PartMesh{part.mesh, nullptr, {}};
    return PartMesh{w_.part_of_mesh(part.mesh, {first.primitive}), nullptr, {}};
  }
  CornerPlan corner_plan = plan_corners(front->types, false, kNone);
  LB_RETURN_IF_ERROR(keep_positions(w_, part, corner_plan));
  LB_ASSIGN_OR_RETURN(Gathered corners, gather(w_, part.pieces, corner_plan, nullptr, false));
  const bool coloured = part.coloured && colours_differ(w_, part.pieces);
  if (coloured) corners.streams.push_back(colour_stream(w_, corners.rows_of_piece));
  std::uint32_t material = w_.gltf_material(part.material);
  if (coloured) material = w_.materials.coloured(material);
  Json primitives = Json::array(), about = Json::array();
  const double scale = largest_scale(w_.scene, plan, index);
  for (MeshData& mesh : build_meshes(std::move(corners.streams), std::move(corners.ranges),
                                     plan.max_vertices, std::move(corners.row_of))) {
    if (grid.step > 0) quantize(w_, mesh, grid.centre, grid.step, scale);
    Json primitive = add_primitive(w_.binary, mesh.types, mesh.data, mesh.indices);
    if (material != kNone) primitive["material"] = material;
    if (const Json* variants = extension(model, "KHR_materials_variants"))
      primitive["extensions"]["KHR_materials_variants"] = *variants;
    for (const IndexRange& r : mesh.ranges)
      about.push_back(range_json(w_, primitives.size(), r, part.coloured));
    primitives.push_back(std::move(primitive));
  }
  Json mesh = source;
  mesh["primitives"] = std::move(primitives);
  return PartMesh{append(w_.root, "meshes", std::move(mesh)), std::move(about), grid};
}

Affine InstanceNodes::placement(std::uint32_t object, const Quantizer::PartGrid& grid) const {
  Affine m = w_.scene.objects[object].to_world;
  if (!(grid.step > 0)) return m;
  m.t = m.point(grid.centre);
  for (Vec3d* axis : {&m.x, &m.y, &m.z}) *axis = *axis * grid.step;
  return m;
}

Json InstanceNodes::attributes_of(const std::vector<std::uint32_t>& objects,
                                  const Quantizer::PartGrid& grid, const Vec3d& frame) {
  std::vector<float> translation, rotation, scale;
  bool turned = false, scaled = false;
  for (const std::uint32_t o : objects) {
    const Affine m = placement(o, grid);
    const Turn turn = turn_of(m);
    const Vec3f t = to_float(m.t - frame), s = to_float(turn.scale);
    translation.insert(translation.end(), {t.x, t.y, t.z});
    for (const double c : turn.rotation) rotation.push_back(static_cast<float>(c));
    scale.insert(scale.end(), {s.x, s.y, s.z});
    turned = turned || rotation.back() != 1;
    scaled = scaled || s != Vec3f{1, 1, 1};
  }
  Json attributes{{"TRANSLATION", w_.binary.add_instance_floats(translation, 3)}};
  if (turned) attributes["ROTATION"] = w_.binary.add_instance_floats(rotation, 4);
  if (scaled) attributes["SCALE"] = w_.binary.add_instance_floats(scale, 3);
  return attributes;
}

Result<Json> InstanceNodes::node_of(const batches::BatchPlan& plan,
                                    const batches::InstanceCell& cell) {
  const auto [part, fresh] = meshes_.try_emplace(cell.part);
  if (fresh) {
    LB_ASSIGN_OR_RETURN(part->second, mesh_of(plan, cell.part));
  }
  const Quantizer::PartGrid& grid = part->second.grid;
  const Affine first = placement(cell.objects.front(), grid);
  Json node{{"mesh", part->second.mesh}};
  if (cell.objects.size() == 1) {
    const Turn turn = turn_of(first);
    node["translation"] = json_of(first.t);
    if (turn.rotation[3] != 1) node["rotation"] = turn.rotation;
    if (turn.scale != Vec3d{1, 1, 1}) node["scale"] = json_of(turn.scale);
  } else {
    // Viewers draw near nodes first, by their origins, so that what is hidden costs no shading.
    const Vec3d frame = to_double(to_float(w_.scene.origin + to_double(cell.box.centre())));
    if (frame != Vec3d{}) node["translation"] = json_of(frame);
    node["extensions"][kInstancing]["attributes"] = attributes_of(cell.objects, grid, frame);
    declare_extension(w_.root, "extensionsUsed", kInstancing);
    // Without it a reader would draw one instance of many.
    declare_extension(w_.root, "extensionsRequired", kInstancing);
  }
  Json names = Json::array();
  for (const std::uint32_t o : cell.objects) names.push_back(w_.scene.objects[o].node);
  Json& about = node["extras"]["lightbatch"];
  about["nodes"] = std::move(names);
  if (!part->second.ranges.is_null()) about["ranges"] = part->second.ranges;
  Json box = json_of(w_.scene.origin + to_double(cell.box.lower));
  for (const Json& v : json_of(w_.scene.origin + to_double(cell.box.upper))) box.push_back(v);
  about["box"] = std::move(box);
  return node;
}

}  // namespace lightbatch::scene_out
