// Draco bitstream 2.2, sequential connectivity: Edgebreaker codes smaller, but puts triangles and
// vertices into an order of its own.
#include "core/scene_out/draco_encode.h"

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/parallel.h"
#include "core/gltf/accessor.h"
#include "core/gltf/draco_types.h"
#include "core/scene_out/corners.h"
#include "core/scene_out/json_access.h"
#include "core/scene_out/pack.h"
#include "core/scene_out/references.h"
#include "core/scene_out/source_mesh.h"

namespace lightbatch::scene_out {
namespace {

constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr int kNormalBits = 12;
constexpr int kPositionBits = 14;  // of the median mesh
constexpr float kTextureStep = 1.0f / 65536;
/// As fine as the normals' bits; a power of two, so that w stays 1 or -1 but for an ulp.
constexpr float kTangentStep = 1.0f / 2048;
/// Beyond, steps and places on the grid would not be exact in float.
constexpr int kMostBits = 22;

/// Bytes of a stream before its triangles, at most.
constexpr std::size_t kHeaderBytes = 32;

/// Values of one attribute on a grid, or all of their bits.
struct Grid {
  int bits = 0;  // 0: exact
  std::vector<float> origin;
  float step = 0;
};

/// One stream, for all primitives with the same attributes and indices.
struct Stream {
  Json attributes, indices;  // as they were
  std::vector<AttributeType> types;
  std::vector<Bytes> data;
  std::vector<std::uint32_t> corners;
  std::size_t points = 0;
  bool thinned = false;  // vertices were dropped
  Json position_bounds;  // of a thinned stream: min and max
  std::vector<Json*> primitives;
  std::vector<Grid> grids;        // by attribute
  std::vector<std::uint32_t> id;  // by attribute, in the stream
  Bytes bytes;
  bool ok = false;
};

bool can_compress(const Json& root, const Json& primitive) {
  const std::uint32_t mode = index_at(primitive, "mode");
  if (mode != kNone && mode != 4) return false;
  if (!primitive.contains("indices") || primitive.contains("targets")) return false;
  const Json& indices = root.at("accessors").at(index_at(primitive, "indices"));
  if (indices.at("count").get<std::uint64_t>() % 3 != 0) return false;
  for (const auto& [name, accessor] : primitive.at("attributes").items()) {
    if (name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_")) return false;
    if (!root.at("accessors").at(accessor.get<std::size_t>()).contains("bufferView")) return false;
  }
  return true;
}

struct Bounds {
  std::vector<float> low, high;
};
Bounds bounds_of(const AttributeType& type, const Bytes& data) {
  const auto n = static_cast<std::size_t>(type.components);
  Bounds b{std::vector<float>(n, INFINITY), std::vector<float>(n, -INFINITY)};
  for (std::size_t i = 0; i * sizeof(float) < data.size(); ++i) {
    float v;
    std::memcpy(&v, data.data() + i * sizeof(float), sizeof v);
    b.low[i % n] = std::min(b.low[i % n], v);
    b.high[i % n] = std::max(b.high[i % n], v);
  }
  return b;
}

float extent_of(const Bounds& b) {
  float extent = 0;
  for (std::size_t c = 0; c < b.low.size(); ++c) extent = std::max(extent, b.high[c] - b.low[c]);
  return extent;
}

bool is_position(const AttributeType& type) {
  return type.name == "POSITION" && type.component_type == 5126;
}

/// The power of two that gives the median mesh kPositionBits.
float position_step(const std::vector<Stream>& streams) {
  std::vector<float> extents;
  for (const Stream& s : streams)
    for (std::size_t a = 0; a < s.types.size(); ++a)
      if (is_position(s.types[a])) extents.push_back(extent_of(bounds_of(s.types[a], s.data[a])));
  if (extents.empty()) return 1;
  const auto middle = extents.begin() + static_cast<std::ptrdiff_t>(extents.size() / 2);
  std::nth_element(extents.begin(), middle, extents.end());
  return *middle > 0 ? std::exp2(std::floor(std::log2(*middle)) - kPositionBits) : 1;
}

/// A grid of that step over the values; exact where it would not pay or fit.
Grid grid_of(const AttributeType& type, const Bytes& data, float step) {
  Grid grid;
  const Bounds b = bounds_of(type, data);
  const int bits = static_cast<int>(std::ceil(std::log2(extent_of(b) / step + 2)));
  if (!(bits <= kMostBits)) return grid;
  for (const float low : b.low) {
    const float origin = std::floor(low / step) * step;
    if (!(std::abs(origin) < step * (1 << 23))) return grid;
    grid.origin.push_back(origin);
  }
  grid.bits = std::max(bits, 1);
  grid.step = step;
  return grid;
}

draco::GeometryAttribute::Type semantic(const AttributeType& type) {
  // Normals that are not float stay exact: Draco would round them.
  if (type.name == "POSITION") return draco::GeometryAttribute::POSITION;
  if (type.name == "NORMAL" && type.component_type == 5126) return draco::GeometryAttribute::NORMAL;
  if (type.name.starts_with("TEXCOORD_")) return draco::GeometryAttribute::TEX_COORD;
  if (type.name.starts_with("COLOR_")) return draco::GeometryAttribute::COLOR;
  return draco::GeometryAttribute::GENERIC;
}

void choose_grids(Stream& s, float step) {
  for (std::size_t a = 0; a < s.types.size(); ++a) {
    const AttributeType& type = s.types[a];
    s.grids.emplace_back();
    if (type.component_type != 5126) continue;
    if (is_position(type)) s.grids.back() = grid_of(type, s.data[a], step);
    if (type.name == "TANGENT") s.grids.back() = grid_of(type, s.data[a], kTangentStep);
    if (type.name.starts_with("TEXCOORD_")) s.grids.back() = grid_of(type, s.data[a], kTextureStep);
  }
}

/// min and max of an accessor of these values.
Json stored_bounds(AttributeType type, const Bytes& data) {
  type.normalized = false;
  Json low = Json::array(), high = Json::array();
  for (std::size_t c = 0; c < static_cast<std::size_t>(type.components); ++c) {
    double lowest = INFINITY, highest = -INFINITY;
    for (std::size_t at = 0; at < data.size(); at += type.bytes()) {
      const double value = component(type, data.data() + at, c);
      lowest = std::min(lowest, value);
      highest = std::max(highest, value);
    }
    const bool whole = type.component_type != 5126;
    low.push_back(whole ? Json(static_cast<std::int64_t>(lowest)) : Json(lowest));
    high.push_back(whole ? Json(static_cast<std::int64_t>(highest)) : Json(highest));
  }
  return {{"min", std::move(low)}, {"max", std::move(high)}};
}

/// Drops vertices that no triangle has: decoders refuse streams of more points than corners, and
/// primitives that share vertices would each hold all of them.
void drop_unused(Stream& s) {
  s.points = s.data.front().size() / s.types.front().bytes();
  std::vector<std::uint32_t> number(s.points, kNone);
  for (const std::uint32_t corner : s.corners) number[corner] = 0;
  std::uint32_t kept = 0;
  for (std::uint32_t& n : number)
    if (n != kNone) n = kept++;
  s.thinned = kept < s.points;
  if (!s.thinned) return;
  for (std::uint32_t& corner : s.corners) corner = number[corner];
  for (std::size_t a = 0; a < s.types.size(); ++a) {
    const std::size_t size = s.types[a].bytes();
    for (std::size_t v = 0; v < s.points; ++v)
      if (number[v] != kNone)
        std::memmove(s.data[a].data() + number[v] * size, s.data[a].data() + v * size, size);
    s.data[a].resize(kept * size);
    if (s.types[a].name == "POSITION") s.position_bounds = stored_bounds(s.types[a], s.data[a]);
  }
  s.points = kept;
}

void encode(Stream& s) {
  draco::Mesh mesh;
  mesh.set_num_points(static_cast<std::uint32_t>(s.points));
  mesh.SetNumFaces(s.corners.size() / 3);
  for (std::uint32_t f = 0; f < mesh.num_faces(); ++f)
    mesh.SetFace(draco::FaceIndex(f),
                 {draco::PointIndex(s.corners[3 * f]), draco::PointIndex(s.corners[3 * f + 1]),
                  draco::PointIndex(s.corners[3 * f + 2])});
  std::vector<int> ids;
  for (std::size_t a = 0; a < s.types.size(); ++a) {
    const AttributeType& type = s.types[a];
    draco::PointAttribute attribute;
    attribute.Init(semantic(type), static_cast<std::int8_t>(type.components),
                   gltf::draco_type_of(static_cast<std::uint32_t>(type.component_type)),
                   type.normalized, s.points);
    attribute.buffer()->Write(0, s.data[a].data(), s.data[a].size());
    ids.push_back(mesh.AddAttribute(std::make_unique<draco::PointAttribute>(std::move(attribute))));
    s.id.push_back(mesh.attribute(ids.back())->unique_id());
  }
  draco::ExpertEncoder encoder(mesh);
  encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
  encoder.options().SetGlobalBool("compress_connectivity", true);
  encoder.SetSpeedOptions(3, 3);
  for (std::size_t a = 0; a < s.types.size(); ++a) {
    const Grid& grid = s.grids[a];
    if (grid.bits > 0)
      encoder.SetAttributeExplicitQuantization(
          ids[a], grid.bits, s.types[a].components, grid.origin.data(),
          grid.step * static_cast<float>((1 << grid.bits) - 1));
    else if (semantic(s.types[a]) == draco::GeometryAttribute::NORMAL)
      encoder.SetAttributeQuantization(ids[a], kNormalBits);
  }
  draco::EncoderBuffer out;
  s.ok = encoder.EncodeToBuffer(&out).ok();
  // Decoders refuse streams of fewer than 3 bytes a triangle; what is stored plainly has as many.
  if (s.ok && out.size() < 3 * (mesh.num_faces() + kHeaderBytes)) {
    out.Clear();
    encoder.options().SetGlobalBool("compress_connectivity", false);
    s.ok = encoder.EncodeToBuffer(&out).ok();
  }
  const auto* raw = reinterpret_cast<const std::byte*>(out.data());
  s.bytes.assign(raw, raw + out.size());
}

/// Accessors of one stream: data of their own, bounds as rounded.
void attach(Json& root, Stream& s, std::uint32_t view) {
  const auto clone = [&](const Json& accessor) {
    Json copy = root.at("accessors").at(accessor.get<std::size_t>());
    for (const char* key : {"bufferView", "byteOffset", "sparse"}) copy.erase(key);
    return append(root, "accessors", std::move(copy));
  };
  Json attributes = Json::object(), ids = Json::object();
  for (std::size_t a = 0; a < s.types.size(); ++a) {
    const std::uint32_t index = clone(s.attributes.at(s.types[a].name));
    if (s.thinned) {
      root["accessors"][index]["count"] = s.points;
      for (const char* key : {"min", "max"}) root["accessors"][index].erase(key);
      if (s.types[a].name == "POSITION") root["accessors"][index].update(s.position_bounds);
    }
    attributes[s.types[a].name] = index;
    ids[s.types[a].name] = s.id[a];
    const Grid& grid = s.grids[a];
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
  const std::uint32_t indices = clone(s.indices);
  for (Json* primitive : s.primitives) {
    (*primitive)["attributes"] = attributes;
    (*primitive)["indices"] = indices;
    (*primitive)["extensions"][kDraco] = {{"bufferView", view}, {"attributes", ids}};
  }
}

}  // namespace

Result<Bytes> compress_draco(Json& root, const Json& before, Bytes binary) {
  const Pins pins = find_pins(before);
  if (!pins.views.empty() || !pins.accessors.empty() || !root.contains("meshes")) return binary;
  gltf::Document packed;
  packed.json = root;
  packed.buffers.push_back(std::move(binary));
  std::map<std::string, std::size_t> known;
  std::vector<Stream> streams;
  for (Json& mesh : root["meshes"])
    for (Json& primitive : mesh["primitives"]) {
      if (!can_compress(root, primitive)) continue;
      const std::string key = primitive.at("attributes").dump() + primitive.at("indices").dump();
      const auto [it, fresh] = known.try_emplace(key, streams.size());
      if (fresh) {
        Stream& s = streams.emplace_back();
        s.attributes = primitive.at("attributes");
        s.indices = primitive.at("indices");
        s.types = attribute_types(root, primitive);
        for (const AttributeType& type : s.types) {
          LB_ASSIGN_OR_RETURN(Bytes data,
                              gltf::read_packed(packed, index_at(s.attributes, type.name)));
          s.data.push_back(std::move(data));
        }
        LB_ASSIGN_OR_RETURN(s.corners, gltf::read_indices(packed, index_at(primitive, "indices")));
      }
      streams[it->second].primitives.push_back(&primitive);
    }
  const float step = position_step(streams);
  parallel_for(streams.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      drop_unused(streams[i]);
      choose_grids(streams[i], step);
      encode(streams[i]);
      streams[i].data.clear();
      streams[i].corners.clear();
    }
  });
  Bytes coded;
  bool any = false;
  for (Stream& s : streams) {
    if (!s.ok) continue;
    any = true;
    coded.resize((coded.size() + 3) / 4 * 4);
    attach(
        root, s,
        append(root, "bufferViews",
               Json{{"buffer", 1}, {"byteOffset", coded.size()}, {"byteLength", s.bytes.size()}}));
    coded.insert(coded.end(), s.bytes.begin(), s.bytes.end());
  }
  if (!any) return std::move(packed.buffers.front());
  declare_extension(root, "extensionsUsed", kDraco);
  declare_extension(root, "extensionsRequired", kDraco);
  const Bytes* buffers[] = {&packed.buffers.front(), &coded};
  return pack(root, packed.json, buffers);
}

}  // namespace lightbatch::scene_out
