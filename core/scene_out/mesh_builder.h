#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/bytes.h"
#include "core/scene_out/source_mesh.h"

namespace lightbatch::scene_out {

/// A run of the index buffer that came from one object.
struct IndexRange {
  std::uint32_t object = 0;
  std::uint32_t first = 0;  // index
  std::uint32_t count = 0;  // indices
};

/// An indexed mesh: attributes of equal count, a list of triangles, and where they came from.
struct MeshData {
  std::vector<AttributeType> types;
  std::vector<Bytes> data;  // one per type, packed
  std::vector<std::uint32_t> indices;
  std::vector<IndexRange> ranges;  // cover the indices, in order
  std::uint32_t vertex_count = 0;
};

/// One stream of values, one for each row; corners of triangles refer to rows.
struct CornerStream {
  AttributeType type;
  Bytes bytes;
};

/// row_of: of each corner; empty: each corner has its own, in order. Rows with equal bytes in all
/// streams become one vertex. Triangles are ordered within their
/// range for the vertex cache and against overdraw (`positions`: stream of float VEC3 to judge
/// it by, or null), vertices for fetching (meshoptimizer). Split into several meshes where one
/// would have more than max_vertices.
std::vector<MeshData> build_meshes(std::vector<CornerStream> streams,
                                   std::vector<IndexRange> ranges, std::uint32_t max_vertices,
                                   std::vector<std::uint32_t> row_of = {});

/// Equal rows get equal ids: ids are refined by one more stream of `size` bytes a row.
/// Returns how many there are. Start with all ids 0.
std::uint32_t refine_ids(std::vector<std::uint32_t>& ids, std::span<const std::byte> bytes,
                         std::size_t size);

}  // namespace lightbatch::scene_out
