#include "core/scene_out/draco_mesh.h"

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>

#include "core/gltf/draco_types.h"
#include "core/scene_out/corners.h"

namespace lightbatch::scene_out {
namespace {

constexpr int kNormalBits = 12;
constexpr int kPositionBits = 14;  // of the median mesh
/// Of meshes far smaller than that, whose shape the common grid would not hold.
constexpr int kLeastBits = 11;
constexpr float kTextureStep = 1.0f / 65536;
/// As fine as the normals' bits; a power of two, so that w stays 1 or -1 but for an ulp.
constexpr float kTangentStep = 1.0f / 2048;
/// Beyond, steps and places on the grid would not be exact in float.
constexpr int kMostBits = 22;

/// Bytes of a stream before its triangles, at most.
constexpr std::size_t kHeaderBytes = 32;

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

/// A grid of that step over the values; exact where it would not pay or fit.
DracoGrid grid_of(const AttributeType& type, const Bytes& data, float step) {
  DracoGrid grid;
  const Bounds b = bounds_of(type, data);
  const float bits = std::ceil(std::log2(extent_of(b) / step + 2));
  if (!(bits <= static_cast<float>(kMostBits))) return grid;  // infinite, too
  for (const float low : b.low) {
    const float origin = std::floor(low / step) * step;
    if (!(std::abs(origin) < step * (1 << 23))) return grid;
    grid.origin.push_back(origin);
  }
  grid.bits = std::max(static_cast<int>(bits), 1);
  grid.step = step;
  return grid;
}

void choose_grids(DracoMesh& s, float step) {
  for (std::size_t a = 0; a < s.types.size(); ++a) {
    const AttributeType& type = s.types[a];
    s.grids.emplace_back();
    if (type.component_type != 5126) continue;
    if (is_position(type)) {
      const float extent = extent_of(bounds_of(type, s.data[a]));
      const float own = extent > 0 ? std::exp2(std::floor(std::log2(extent)) - kLeastBits) : step;
      s.grids.back() = grid_of(type, s.data[a], std::min(step, own));
    }
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

std::string exact_text(float value) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

/// Drops vertices that no triangle has: decoders refuse streams of more points than corners, and
/// primitives that share vertices would each hold all of them.
void drop_unused(DracoMesh& s) {
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

void encode_sequential(DracoMesh& s) {
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
    attribute.Init(draco_semantic(type), static_cast<std::int8_t>(type.components),
                   gltf::draco_type_of(static_cast<std::uint32_t>(type.component_type)),
                   type.normalized, s.points);
    attribute.buffer()->Write(0, s.data[a].data(), s.data[a].size());
    ids.push_back(mesh.AddAttribute(std::make_unique<draco::PointAttribute>(std::move(attribute))));
    s.id.push_back(mesh.attribute(ids.back())->unique_id());
  }
  draco::ExpertEncoder encoder(mesh);
  encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
  encoder.options().SetGlobalBool("compress_connectivity", true);
  set_options(s, ids, encoder);
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

}  // namespace

float position_step(const std::vector<const DracoMesh*>& meshes) {
  std::vector<float> extents;
  for (const DracoMesh* s : meshes)
    for (std::size_t a = 0; a < s->types.size(); ++a)
      if (is_position(s->types[a]))
        extents.push_back(extent_of(bounds_of(s->types[a], s->data[a])));
  if (extents.empty()) return 1;
  const auto middle = extents.begin() + static_cast<std::ptrdiff_t>(extents.size() / 2);
  std::nth_element(extents.begin(), middle, extents.end());
  return *middle > 0 ? std::exp2(std::floor(std::log2(*middle)) - kPositionBits) : 1;
}

draco::GeometryAttribute::Type draco_semantic(const AttributeType& type) {
  // Normals that are not float stay exact: Draco would round them.
  if (type.name == "POSITION") return draco::GeometryAttribute::POSITION;
  if (type.name == "NORMAL" && type.component_type == 5126) return draco::GeometryAttribute::NORMAL;
  if (type.name.starts_with("TEXCOORD_")) return draco::GeometryAttribute::TEX_COORD;
  if (type.name.starts_with("COLOR_")) return draco::GeometryAttribute::COLOR;
  return draco::GeometryAttribute::GENERIC;
}

void set_options(const DracoMesh& s, const std::vector<int>& ids, draco::ExpertEncoder& encoder) {
  encoder.SetSpeedOptions(5, 5);
  for (std::size_t a = 0; a < s.types.size(); ++a) {
    const DracoGrid& grid = s.grids[a];
    if (grid.bits > 0) {
      // Set as floats, options keep six decimals.
      draco::Options exact;
      exact.SetInt("quantization_bits", grid.bits);
      exact.SetString("quantization_range",
                      exact_text(grid.step * static_cast<float>((1 << grid.bits) - 1)));
      std::string origin;
      for (const float low : grid.origin) origin += exact_text(low) + " ";
      exact.SetString("quantization_origin", origin);
      encoder.options().SetAttributeOptions(ids[a], exact);
    } else if (draco_semantic(s.types[a]) == draco::GeometryAttribute::NORMAL) {
      encoder.SetAttributeQuantization(ids[a], kNormalBits);
    }
  }
}

void encode_draco(DracoMesh& s, float step) {
  drop_unused(s);
  choose_grids(s, step);
  if (s.runs.empty() || !encode_edgebreaker(s)) encode_sequential(s);
  s.data.clear();
  s.corners.clear();
}

}  // namespace lightbatch::scene_out
