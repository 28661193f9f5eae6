#include "core/scene_out/batch_meshes.h"

#include <algorithm>

#include "core/scene_out/colours.h"
#include "core/scene_out/gather.h"
#include "core/scene_out/instance_cells.h"
#include "core/scene_out/mesh_builder.h"
#include "core/scene_out/names.h"
#include "core/scene_out/portable.h"
#include "core/scene_out/quantize.h"
#include "core/scene_out/range_json.h"

namespace lightbatch::scene_out {
namespace {

Json vec_json(const Vec3d& v) { return Json::array({v.x, v.y, v.z}); }

/// What goes with the meshes of a group.
struct GroupLook {
  std::uint32_t material = kNone;
  Json variants;  // KHR_materials_variants, or null; equal for all objects of a layout
};

GroupLook look_of(const Writer& w, const batches::Group& group) {
  GroupLook look;
  look.material = w.gltf_material(group.material);
  const scene::Object& first = w.scene.objects[group.pieces.front().object];
  const Json& source =
      w.document.json.at("meshes").at(first.mesh).at("primitives").at(first.primitive);
  if (const Json* variants = extension(source, "KHR_materials_variants")) look.variants = *variants;
  return look;
}

/// Calls visit(slot) for the number of every material of a group.
template <typename Visit>
void for_each_material(GroupLook& look, const Visit& visit) {
  visit(look.material);
  Json* mappings = member(look.variants, "mappings");
  if (mappings == nullptr) return;
  for (Json& mapping : *mappings) {
    std::uint32_t material = index_at(mapping, "material");
    visit(material);
    mapping["material"] = material;
  }
}

/// The meshes of a group; the look gets its lightmap.
Result<std::vector<MeshData>> group_meshes(Writer& w, const batches::Group& group,
                                           const Vec3d& frame, std::uint32_t max_vertices,
                                           GroupLook& look) {
  const bool lit = group.page != kNone;
  if (lit && w.portable()) {
    look.material = portable_material(w, group.material);
    look.variants = nullptr;  // baked light is of one look
    Pieces pieces;
    for (const batches::Piece& piece : group.pieces) {
      pieces.push_back({piece.object, {}});
      for (const batches::Range& r : piece.ranges)
        for (std::uint32_t t = r.first; t < r.first + r.count; ++t)
          pieces.back().second.push_back(t);
    }
    return portable_meshes(w, pieces, &frame, max_vertices);
  }
  const scene::Object& first = w.scene.objects[group.pieces.front().object];
  LB_ASSIGN_OR_RETURN(const SourcePrimitive* source, w.sources.get(first.mesh, first.primitive));
  const bool coloured = group.coloured && colours_differ(w, group.pieces);
  if (coloured) look.material = w.materials.coloured(look.material);
  std::uint32_t moved = kNone;
  if (lit) {
    for_each_material(look, [&](std::uint32_t material) {
      if (uses_uv_set(w.root, material, 1)) moved = free_uv_set(source->types);
    });
    for_each_material(look, [&](std::uint32_t& material) {
      material = w.materials.with_lightmap(material, group.page, moved);
    });
  }
  CornerPlan plan = plan_corners(source->types, lit, moved);
  if (!std::all_of(group.pieces.begin(), group.pieces.end(), [&](const batches::Piece& piece) {
        return leads_to_integers(w.scene.objects[piece.object].to_world);
      }))
    widen_directions(plan);
  LB_ASSIGN_OR_RETURN(Gathered corners, gather(w, group.pieces, plan, &frame, lit));
  if (coloured) corners.streams.push_back(colour_stream(w, corners.rows_of_piece));
  return build_meshes(std::move(corners.streams), std::move(corners.ranges), max_vertices,
                      std::move(corners.row_of));
}

/// Where a run of indices of a batch came from, for extras.
Json batch_range_json(const Writer& w, std::size_t primitive, const IndexRange& range,
                      bool coloured) {
  const scene::Object& object = w.scene.objects[range.object];
  Json json = range_json(w, primitive, range, coloured);
  json["node"] = object.node;
  json["name"] = object.name;
  if (object.instance != kNone) json["instance"] = object.instance;
  const Json& mesh = w.document.json.at("meshes").at(object.mesh);
  if (const Json* name = member(mesh, "name"); name != nullptr && *name != object.name)
    json["mesh"] = *name;
  if (const Json* extras = member(mesh, "extras")) json["mesh_extras"] = *extras;
  return json;
}

Result<Json> batch_node(Writer& w, const batches::Batch& batch, std::uint32_t max_vertices,
                        double step, const std::string& name) {
  const Vec3d frame = frame_of(w.scene, batch.box);
  Json primitives = Json::array(), ranges = Json::array();
  for (const batches::Group& group : batch.groups) {
    GroupLook look = look_of(w, group);
    LB_ASSIGN_OR_RETURN(std::vector<MeshData> meshes,
                        group_meshes(w, group, frame, max_vertices, look));
    for (MeshData& mesh : meshes) {
      if (step > 0) quantize(w, mesh, {}, step, 1);
      Json primitive = add_primitive(w.binary, mesh.types, mesh.data, mesh.indices);
      if (look.material != kNone) primitive["material"] = look.material;
      if (!look.variants.is_null())
        primitive["extensions"]["KHR_materials_variants"] = look.variants;
      for (const IndexRange& r : mesh.ranges)
        ranges.push_back(batch_range_json(w, primitives.size(), r, group.coloured));
      primitives.push_back(std::move(primitive));
    }
  }
  Json box = vec_json(w.scene.origin + to_double(batch.box.lower));
  for (const Json& v : vec_json(w.scene.origin + to_double(batch.box.upper))) box.push_back(v);
  const std::uint32_t mesh =
      append(w.root, "meshes", Json{{"name", name}, {"primitives", std::move(primitives)}});
  Json node{{"name", name}, {"mesh", mesh}};
  if (frame != Vec3d{}) node["translation"] = vec_json(frame);
  if (step > 0) node["scale"] = vec_json({step, step, step});
  node["extras"]["lightbatch"] = {{"box", std::move(box)}, {"ranges", std::move(ranges)}};
  return node;
}

}  // namespace

Status add_batches(Writer& w, const batches::BatchPlan& plan, std::uint32_t scene_index) {
  const Quantizer quantizer(w, plan);
  Json children = Json::array();
  if (!plan.tree.empty()) {
    const std::uint32_t base = count_of(w.root, "nodes");
    children.push_back(base);
    for (const batches::TreeNode& tree_node : plan.tree) {
      Json node = Json::object();
      if (tree_node.batch != kNone) {
        LB_ASSIGN_OR_RETURN(node, batch_node(w, plan.batches[tree_node.batch], plan.max_vertices,
                                             quantizer.step_of(plan.batches[tree_node.batch]),
                                             batch_name(tree_node.batch)));
      } else {
        for (const std::uint32_t child : tree_node.children)
          node["children"].push_back(base + child);
      }
      append(w.root, "nodes", std::move(node));
    }
  }
  InstanceNodes instances(w, quantizer);
  for (std::size_t c = 0; c < plan.cells.size(); ++c) {
    LB_ASSIGN_OR_RETURN(Json node, instances.node_of(plan, plan.cells[c]));
    node["name"] = cell_name(c);
    children.push_back(append(w.root, "nodes", std::move(node)));
  }
  if (children.empty()) return {};
  const std::uint32_t top =
      append(w.root, "nodes", Json{{"name", "lightbatch"}, {"children", std::move(children)}});
  Json& nodes = w.root["scenes"][scene_index]["nodes"];
  if (!nodes.is_array()) nodes = Json::array();
  nodes.push_back(top);
  return {};
}

}  // namespace lightbatch::scene_out
