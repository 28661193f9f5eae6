#include "core/scene_out/draco_encode.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/base/parallel.h"
#include "core/gltf/accessor.h"
#include "core/scene_out/draco_mesh.h"
#include "core/scene_out/json_access.h"
#include "core/scene_out/pack.h"

namespace lightbatch::scene_out {
namespace {

constexpr const char* kDraco = "KHR_draco_mesh_compression";

/// A primitive of a mesh of the file.
using Place = std::pair<std::uint32_t, std::uint32_t>;

/// One stream, for all primitives with the same attributes and indices.
struct Stream {
  Json attributes, indices;  // as they were
  DracoMesh mesh;
  std::vector<Json*> primitives;
  std::vector<Place> places;  // of the primitives
};

bool can_compress(const Json& root, const Json& primitive) {
  const std::uint32_t mode = index_at(primitive, "mode");
  if (mode != kNone && mode != 4) return false;
  if (!primitive.contains("indices") || primitive.contains("targets")) return false;
  const Json& indices = root.at("accessors").at(index_at(primitive, "indices"));
  if (indices.at("count").get<std::uint64_t>() % 3 != 0) return false;
  for (const auto& [name, accessor] : primitive.at("attributes").items())
    if (!root.at("accessors").at(accessor.get<std::size_t>()).contains("bufferView")) return false;
  return true;
}

/// How many points indices of an accessor's type may count.
std::uint64_t most_points(const Json& indices) {
  const auto type = indices.at("componentType").get<int>();
  return type == 5121 ? 255 : type == 5123 ? 65535 : kNone;
}

/// What extras say of where triangles came from, by the primitive that draws them.
using Ranges = std::map<Place, std::vector<Json*>>;

Ranges ranges_of(Json& root) {
  Ranges result;
  Json* nodes = member(root, "nodes");
  if (nodes == nullptr) return result;
  for (Json& node : *nodes) {
    Json* extras = member(node, "extras");
    Json* note = extras == nullptr ? nullptr : member(*extras, "lightbatch");
    Json* ranges = note == nullptr ? nullptr : member(*note, "ranges");
    if (ranges == nullptr || !ranges->is_array()) continue;
    for (Json& range : *ranges)
      result[{index_at(node, "mesh"), index_at(range, "primitive")}].push_back(&range);
  }
  return result;
}

/// The runs of triangles that must stay together; none where triangles and vertices must not move:
/// extensions may count on their order, skinned meshes pass through, ranges may overlap.
std::vector<TriangleRun> runs_of(const Stream& s, const Ranges& ranges) {
  const auto triangles = static_cast<std::uint32_t>(s.mesh.corners.size() / 3);
  std::set<std::uint32_t> cuts{0, triangles};
  std::set<std::pair<std::uint32_t, std::uint32_t>> named;
  if (s.attributes.contains("JOINTS_0")) return {};
  for (const Json* primitive : s.primitives)
    if (const Json* extensions = member(*primitive, "extensions"))
      for (const auto& [name, content] : extensions->items())
        if (name != "KHR_materials_variants") return {};
  for (const Place& place : s.places) {
    const auto it = ranges.find(place);
    if (it == ranges.end()) continue;
    for (const Json* range : it->second) {
      const std::uint32_t first = index_at(*range, "first"), count = index_at(*range, "count");
      if (first == kNone || count == kNone || first % 3 != 0 || count % 3 != 0 || count == 0 ||
          first / 3 > triangles || count / 3 > triangles - first / 3)
        return {};
      named.emplace(first / 3, count / 3);
      cuts.insert({first / 3, first / 3 + count / 3});
    }
  }
  std::vector<TriangleRun> runs;
  for (auto it = cuts.begin(); std::next(it) != cuts.end(); ++it)
    runs.push_back({*it, *std::next(it) - *it});
  for (const auto& [first, count] : named) {
    const std::uint32_t begin = first;
    const auto run =
        std::lower_bound(runs.begin(), runs.end(), begin,
                         [](const TriangleRun& r, std::uint32_t value) { return r.first < value; });
    if (run->count != count) return {};
  }
  return runs;
}

/// Tells the ranges where their triangles went.
void move_ranges(const Stream& s, Ranges& ranges) {
  if (s.mesh.moved.empty()) return;
  std::map<std::uint32_t, std::uint32_t> moved;
  for (std::size_t r = 0; r < s.mesh.runs.size(); ++r)
    moved[3 * s.mesh.runs[r].first] = 3 * s.mesh.moved[r];
  for (const Place& place : s.places)
    if (const auto it = ranges.find(place); it != ranges.end())
      for (Json* range : it->second) (*range)["first"] = moved.at(index_at(*range, "first"));
}

/// Accessors of one stream: data of their own, bounds as rounded.
void attach(Json& root, Stream& stream, std::uint32_t view) {
  const DracoMesh& s = stream.mesh;
  const auto clone = [&](const Json& accessor) {
    Json copy = root.at("accessors").at(accessor.get<std::size_t>());
    for (const char* key : {"bufferView", "byteOffset", "sparse"}) copy.erase(key);
    return append(root, "accessors", std::move(copy));
  };
  Json attributes = Json::object(), ids = Json::object();
  for (std::size_t a = 0; a < s.types.size(); ++a) {
    const std::uint32_t index = clone(stream.attributes.at(s.types[a].name));
    root["accessors"][index]["count"] = s.points;
    if (s.thinned) {
      for (const char* key : {"min", "max"}) root["accessors"][index].erase(key);
      if (s.types[a].name == "POSITION") root["accessors"][index].update(s.position_bounds);
    }
    attributes[s.types[a].name] = index;
    ids[s.types[a].name] = s.id[a];
    const DracoGrid& grid = s.grids[a];
    if (grid.bits == 0) continue;
    Json& accessor = root["accessors"][index];
    for (const char* key : {"min", "max"})
      if (Json* list = member(accessor, key))
        for (std::size_t c = 0; c < list->size(); ++c) {
          const float v = (*list)[c].get<float>();
          (*list)[c] =
              grid.origin[c] + std::floor((v - grid.origin[c]) / grid.step + 0.5f) * grid.step;
        }
  }
  const std::uint32_t indices = clone(stream.indices);
  for (Json* primitive : stream.primitives) {
    (*primitive)["attributes"] = attributes;
    (*primitive)["indices"] = indices;
    (*primitive)["extensions"][kDraco] = {{"bufferView", view}, {"attributes", ids}};
  }
}

}  // namespace

Result<Bytes> compress_draco(Json& root, Bytes binary) {
  if (!root.contains("meshes")) return binary;
  gltf::Document packed;
  packed.json = root;
  packed.buffers.push_back(std::move(binary));
  std::map<std::string, std::size_t> known;
  std::vector<Stream> streams;
  for (std::uint32_t m = 0; m < root["meshes"].size(); ++m) {
    Json& primitives = root["meshes"][m]["primitives"];
    for (std::uint32_t k = 0; k < primitives.size(); ++k) {
      Json& primitive = primitives[k];
      if (!can_compress(root, primitive)) continue;
      const std::string key = primitive.at("attributes").dump() + primitive.at("indices").dump();
      const auto [it, fresh] = known.try_emplace(key, streams.size());
      if (fresh) {
        Stream& s = streams.emplace_back();
        s.attributes = primitive.at("attributes");
        s.indices = primitive.at("indices");
        s.mesh.types = attribute_types(root, primitive);
        for (const AttributeType& type : s.mesh.types) {
          LB_ASSIGN_OR_RETURN(Bytes data,
                              gltf::read_packed(packed, index_at(s.attributes, type.name)));
          s.mesh.data.push_back(std::move(data));
        }
        LB_ASSIGN_OR_RETURN(s.mesh.corners,
                            gltf::read_indices(packed, index_at(primitive, "indices")));
        s.mesh.most_points = most_points(root.at("accessors").at(index_at(primitive, "indices")));
      }
      streams[it->second].primitives.push_back(&primitive);
      streams[it->second].places.emplace_back(m, k);
    }
  }
  Ranges ranges = ranges_of(root);
  std::vector<const DracoMesh*> meshes;
  for (Stream& s : streams) {
    s.mesh.runs = runs_of(s, ranges);
    meshes.push_back(&s.mesh);
  }
  const float step = position_step(meshes);
  parallel_for(streams.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) encode_draco(streams[i].mesh, step);
  });
  Bytes coded;
  bool any = false;
  for (Stream& s : streams) {
    if (!s.mesh.ok) continue;
    any = true;
    coded.resize((coded.size() + 3) / 4 * 4);
    attach(root, s,
           append(root, "bufferViews",
                  Json{{"buffer", 1},
                       {"byteOffset", coded.size()},
                       {"byteLength", s.mesh.bytes.size()}}));
    coded.insert(coded.end(), s.mesh.bytes.begin(), s.mesh.bytes.end());
    move_ranges(s, ranges);
  }
  if (!any) return std::move(packed.buffers.front());
  declare_extension(root, "extensionsUsed", kDraco);
  declare_extension(root, "extensionsRequired", kDraco);
  const Bytes* buffers[] = {&packed.buffers.front(), &coded};
  return pack(root, packed.json, buffers);
}

}  // namespace lightbatch::scene_out
