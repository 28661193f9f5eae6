// Rossignac: Edgebreaker, connectivity compression for triangle meshes, 1999, as Draco has it: one
// connected component after the other, in the order of their first triangles; decoders meet all of
// it backwards. A component without a border would leave its first triangle to the very end.
#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/core/quantization_utils.h>
#include <draco/mesh/corner_table.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <numeric>

#include "core/base/random.h"
#include "core/gltf/draco_types.h"
#include "core/scene_out/draco_mesh.h"
#include "core/scene_out/mesh_builder.h"

namespace lightbatch::scene_out {
namespace {

constexpr std::uint32_t kUnset = 0xffffffffu;

/// Points, and the values that they have; no point and no position is in two runs.
struct Points {
  std::vector<std::uint32_t> corners;             // points
  std::vector<std::uint32_t> vertex;              // of the mesh, by point
  std::vector<std::vector<std::uint32_t>> value;  // by attribute and point
  std::vector<std::uint32_t> values;              // how many, by attribute
};

Points points_of(const DracoMesh& mesh) {
  Points p;
  p.corners.resize(mesh.corners.size());
  std::vector<std::uint32_t> last_run(mesh.points, kUnset), point(mesh.points, 0), run_of_point;
  for (std::uint32_t r = 0; r < mesh.runs.size(); ++r) {
    const TriangleRun& run = mesh.runs[r];
    for (std::size_t c = std::size_t{3} * run.first; c < std::size_t{3} * (run.first + run.count);
         ++c) {
      const std::uint32_t v = mesh.corners[c];
      if (last_run[v] != r) {
        last_run[v] = r;
        point[v] = static_cast<std::uint32_t>(p.vertex.size());
        p.vertex.push_back(v);
        run_of_point.push_back(r);
      }
      p.corners[c] = point[v];
    }
  }
  Bytes rows;
  for (std::size_t a = 0; a < mesh.types.size(); ++a) {
    const std::size_t size = mesh.types[a].bytes();
    rows.resize(p.vertex.size() * size);
    for (std::size_t k = 0; k < p.vertex.size(); ++k)
      std::memcpy(rows.data() + k * size, mesh.data[a].data() + p.vertex[k] * size, size);
    std::vector<std::uint32_t>& ids = p.value.emplace_back(run_of_point);
    p.values.push_back(refine_ids(ids, rows, size));
  }
  return p;
}

/// Gives a corner a point and a place of its own, with the same values.
void split_corner(Points& p, std::size_t position, std::size_t corner) {
  const std::uint32_t from = p.corners[corner];
  p.corners[corner] = static_cast<std::uint32_t>(p.vertex.size());
  p.vertex.push_back(p.vertex[from]);
  for (std::size_t a = 0; a < p.value.size(); ++a)
    p.value[a].push_back(a == position ? p.values[a]++ : p.value[a][from]);
}

/// Encoders drop triangles with two corners in one place.
void split_degenerate(Points& p, std::size_t position) {
  const auto place = [&](std::size_t corner) { return p.value[position][p.corners[corner]]; };
  for (std::size_t c = 0; c < p.corners.size(); c += 3) {
    if (place(c) == place(c + 1) || place(c + 1) == place(c + 2)) split_corner(p, position, c + 1);
    if (place(c) == place(c + 2)) split_corner(p, position, c + 2);
  }
}

/// One step towards the order that order_triangles wants: true where it is reached. `order` is that
/// of the triangles so far; which of the edges that more than two triangles share are joined
/// depends on it.
bool improve_order(Points& p, std::size_t position, std::vector<std::uint32_t>& order) {
  const std::size_t count = order.size();
  draco::IndexTypeVector<draco::FaceIndex, draco::CornerTable::FaceType> faces(count);
  for (std::uint32_t f = 0; f < count; ++f)
    for (std::size_t k = 0; k < 3; ++k)
      faces[draco::FaceIndex(f)][k] =
          draco::VertexIndex(p.value[position][p.corners[3 * std::size_t{order[f]} + k]]);
  const std::unique_ptr<draco::CornerTable> table = draco::CornerTable::Create(faces);
  if (table == nullptr) return false;
  bool reached = true;
  std::vector<std::uint32_t> better;  // of the faces of the table
  better.reserve(count);
  std::vector<bool> met(count, false);
  for (std::uint32_t first = 0; first < count; ++first) {
    if (met[first]) continue;
    const std::size_t begin = better.size();
    std::size_t start = kUnset;  // into better
    met[first] = true;
    better.push_back(first);
    for (std::size_t at = begin; at < better.size(); ++at)
      for (std::uint32_t k = 0; k < 3; ++k) {
        const draco::CornerIndex across = table->Opposite(draco::CornerIndex(3 * better[at] + k));
        if (across == draco::kInvalidCornerIndex) {
          start = std::min(start, at);
        } else if (const std::uint32_t f = table->Face(across).value(); !met[f]) {
          met[f] = true;
          better.push_back(f);
        }
      }
    reached = reached && start == begin;
    if (start == kUnset) {
      split_corner(p, position, 3 * std::size_t{order[first]});
      start = begin;
    }
    std::swap(better[begin], better[start]);
  }
  if (reached) return true;
  for (std::uint32_t& f : better) f = order[f];
  order = std::move(better);
  return false;
}

std::vector<int> fill(const DracoMesh& mesh, const Points& p,
                      const std::vector<std::uint32_t>& order, draco::Mesh& out) {
  out.set_num_points(static_cast<std::uint32_t>(p.vertex.size()));
  out.SetNumFaces(order.size());
  for (std::uint32_t f = 0; f < order.size(); ++f) {
    const std::uint32_t* c = &p.corners[3 * std::size_t{order[f]}];
    out.SetFace(draco::FaceIndex(f),
                {draco::PointIndex(c[0]), draco::PointIndex(c[1]), draco::PointIndex(c[2])});
  }
  std::vector<int> ids;
  for (std::size_t a = 0; a < mesh.types.size(); ++a) {
    const AttributeType& type = mesh.types[a];
    auto attribute = std::make_unique<draco::PointAttribute>();
    attribute->Init(draco_semantic(type), static_cast<std::int8_t>(type.components),
                    gltf::draco_type_of(static_cast<std::uint32_t>(type.component_type)),
                    type.normalized, p.values[a]);
    attribute->SetExplicitMapping(p.vertex.size());
    for (std::uint32_t k = 0; k < p.vertex.size(); ++k) {
      const draco::AttributeValueIndex value(p.value[a][k]);
      attribute->SetAttributeValue(value, mesh.data[a].data() + p.vertex[k] * type.bytes());
      attribute->SetPointMapEntry(draco::PointIndex(k), value);
    }
    ids.push_back(out.AddAttribute(std::move(attribute)));
  }
  return ids;
}

/// Sums of triangles that do not depend on any order.
class PlaceSums {
 public:
  PlaceSums(const DracoMesh& mesh, std::size_t position)
      : grid_(mesh.grids[position]), bytes_(mesh.types[position].bytes()) {
    if (grid_.bits > 0)
      quantizer_.Init(grid_.step * static_cast<float>((1 << grid_.bits) - 1),
                      (1 << grid_.bits) - 1);
  }
  /// decoded: already on the grid.
  std::uint64_t corner(const std::byte* place, bool decoded) const {
    std::uint64_t hash = 1;
    if (grid_.bits == 0) {
      for (std::size_t b = 0; b < bytes_; ++b)
        hash = mix_bits(hash ^ static_cast<std::uint64_t>(place[b]));
      return hash;
    }
    for (std::size_t c = 0; c < 3; ++c) {
      float value = 0;
      std::memcpy(&value, place + c * sizeof value, sizeof value);
      value -= grid_.origin[c];
      const auto step = decoded ? std::lround(value / grid_.step) : quantizer_.QuantizeFloat(value);
      hash = mix_bits(hash ^ static_cast<std::uint64_t>(step));
    }
    return hash;
  }

 private:
  const DracoGrid& grid_;
  std::size_t bytes_;
  draco::Quantizer quantizer_;
};

/// Encodes in that order; false where the runs do not come out whole.
bool encode_in_order(DracoMesh& mesh, std::size_t position, const Points& p,
                     const std::vector<std::uint32_t>& order) {
  draco::Mesh source;
  const std::vector<int> ids = fill(mesh, p, order, source);
  draco::ExpertEncoder encoder(source);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  set_options(mesh, ids, encoder);
  draco::EncoderBuffer out;
  if (!encoder.EncodeToBuffer(&out).ok()) return false;

  draco::DecoderBuffer in;
  in.Init(out.data(), out.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&in);
  if (!decoded.ok()) return false;
  const draco::Mesh& result = *decoded.value();
  std::vector<std::uint32_t> unique;
  for (const int id : ids) unique.push_back(source.attribute(id)->unique_id());
  const draco::PointAttribute* places = result.GetAttributeByUniqueId(unique[position]);
  if (places == nullptr || result.num_faces() != order.size() ||
      result.num_points() > mesh.most_points || result.num_points() > mesh.corners.size())
    return false;

  const PlaceSums sums(mesh, position);
  const std::size_t size = mesh.types[position].bytes();
  Bytes place(size);
  std::vector<std::uint32_t> moved(mesh.runs.size());
  std::uint32_t next = 0;
  for (std::size_t r = mesh.runs.size(); r-- > 0;) {
    const TriangleRun& run = mesh.runs[r];
    moved[r] = next;
    std::uint64_t before = 0, after = 0;
    for (std::uint32_t k = 0; k < run.count; ++k) {
      std::uint64_t a = 0, b = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t vertex = mesh.corners[3 * std::size_t{run.first + k} + c];
        a += sums.corner(mesh.data[position].data() + vertex * size, false);
        places->GetMappedValue(result.face(draco::FaceIndex(next))[c], place.data());
        b += sums.corner(place.data(), true);
      }
      before += mix_bits(a);
      after += mix_bits(b);
      ++next;
    }
    if (before != after) return false;
  }
  const auto* raw = reinterpret_cast<const std::byte*>(out.data());
  mesh.bytes.assign(raw, raw + out.size());
  mesh.id = std::move(unique);
  mesh.points = result.num_points();
  mesh.moved = std::move(moved);
  mesh.ok = true;
  return true;
}

}  // namespace

bool encode_edgebreaker(DracoMesh& mesh) {
  std::size_t position = 0;
  while (position < mesh.types.size() && mesh.types[position].name != "POSITION") ++position;
  if (position == mesh.types.size() || mesh.corners.empty()) return false;
  Points p = points_of(mesh);
  split_degenerate(p, position);
  constexpr int kTries = 4;
  std::vector<std::uint32_t> order(p.corners.size() / 3);
  std::iota(order.begin(), order.end(), 0u);
  for (int i = 0; i < kTries; ++i) {
    const bool reached = improve_order(p, position, order);
    if (encode_in_order(mesh, position, p, order)) return true;
    if (reached) break;
  }
  return false;
}

}  // namespace lightbatch::scene_out
