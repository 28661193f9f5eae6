#pragma once

#include <draco/attributes/geometry_attribute.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/gltf/document.h"
#include "core/scene_out/source_mesh.h"

namespace draco {
class ExpertEncoder;
}

namespace lightbatch::scene_out {

/// Values of one attribute on a grid, or all of their bits.
struct DracoGrid {
  int bits = 0;  // 0: exact
  std::vector<float> origin;
  float step = 0;
};

/// Triangles first, first + 1, ... of a mesh.
struct TriangleRun {
  std::uint32_t first = 0, count = 0;
};

/// Triangles and attributes of one stream, and the stream.
struct DracoMesh {
  std::vector<AttributeType> types;
  std::vector<Bytes> data;  // by attribute; empty once encoded
  std::vector<std::uint32_t> corners;
  /// Runs of triangles that something names, in order, each triangle in one. Triangles of a run get
  /// an order of their own, runs too: `moved` says where each begins. Empty: nothing may move.
  std::vector<TriangleRun> runs;
  std::vector<std::uint32_t> moved;  // by run; empty: all stay
  std::uint64_t most_points = 0;     // that indices may count

  std::size_t points = 0;         // of the stream
  bool thinned = false;           // vertices were dropped
  gltf::Json position_bounds;     // of a thinned mesh: min and max
  std::vector<DracoGrid> grids;   // by attribute
  std::vector<std::uint32_t> id;  // by attribute, in the stream
  Bytes bytes;
  bool ok = false;
};

/// The power of two that gives the median mesh 14 bits of each coordinate.
float position_step(const std::vector<const DracoMesh*>& meshes);

/// Encodes a mesh and lets its data go. Float positions are rounded to whole steps.
void encode_draco(DracoMesh& mesh, float step);

/// Edgebreaker connectivity: smaller, in another order. False where the runs or the number of
/// points would not come out as they should; the mesh is as before then.
bool encode_edgebreaker(DracoMesh& mesh);

draco::GeometryAttribute::Type draco_semantic(const AttributeType& type);

/// Speed, and rounding of every attribute as the mesh's grids say. ids: of the encoder's.
void set_options(const DracoMesh& mesh, const std::vector<int>& ids, draco::ExpertEncoder& encoder);

}  // namespace lightbatch::scene_out
