#include "core/scene_out/mesh_builder.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "core/base/check.h"
#include "core/base/random.h"

namespace lightbatch::scene_out {
namespace {

constexpr std::uint32_t kUnset = 0xffffffffu;

/// Sander, Nehab, Barczak: Fast triangle reordering for vertex locality and reduced overdraw, 2007:
/// the vertex cache may lose this share for less overdraw.
constexpr float kOverdrawThreshold = 1.05f;

void order_triangles(MeshData& mesh, std::size_t position_stream) {
  const bool floats = mesh.types[position_stream].component_type == 5126;
  std::vector<std::uint32_t> sorted;
  // Vertices of a range get small numbers first: the optimiser's tables then have the size of the
  // range, not of the mesh.
  std::vector<std::uint32_t> local(mesh.vertex_count, kUnset), global;
  std::vector<Vec3f> positions;
  for (const IndexRange& range : mesh.ranges) {
    const std::span<std::uint32_t> part(mesh.indices.data() + range.first, range.count);
    global.clear();
    for (std::uint32_t& i : part) {
      if (local[i] == kUnset) {
        local[i] = static_cast<std::uint32_t>(global.size());
        global.push_back(i);
      }
      i = local[i];
    }
    sorted.resize(part.size());
    meshopt_optimizeVertexCache(sorted.data(), part.data(), part.size(), global.size());
    if (floats) {
      positions.resize(global.size());
      for (std::size_t v = 0; v < global.size(); ++v)
        std::memcpy(&positions[v], mesh.data[position_stream].data() + global[v] * sizeof(Vec3f),
                    sizeof(Vec3f));
      meshopt_optimizeOverdraw(part.data(), sorted.data(), part.size(), &positions[0].x,
                               positions.size(), sizeof(Vec3f), kOverdrawThreshold);
    } else {
      std::copy(sorted.begin(), sorted.end(), part.begin());
    }
    for (std::uint32_t& i : part) i = global[i];
    for (const std::uint32_t v : global) local[v] = kUnset;
  }
}

/// Numbers vertices in the order of their first use, and drops those without a use.
void order_vertices(MeshData& mesh) {
  std::vector<std::uint32_t> remap(mesh.vertex_count, kUnset);
  std::uint32_t next = 0;
  for (std::uint32_t& i : mesh.indices) {
    if (remap[i] == kUnset) remap[i] = next++;
    i = remap[i];
  }
  for (std::size_t s = 0; s < mesh.types.size(); ++s) {
    const std::size_t size = mesh.types[s].bytes();
    Bytes moved(next * size);
    for (std::uint32_t v = 0; v < mesh.vertex_count; ++v)
      if (remap[v] != kUnset)
        std::memcpy(moved.data() + remap[v] * size, mesh.data[s].data() + v * size, size);
    mesh.data[s] = std::move(moved);
  }
  mesh.vertex_count = next;
}

/// Cuts the list of triangles so that no part uses more than max_vertices.
std::vector<MeshData> split(const MeshData& mesh, std::uint32_t max_vertices) {
  std::vector<MeshData> parts;
  std::vector<std::uint32_t> part_of(mesh.vertex_count, 0);  // 1 + last part that used the vertex
  std::vector<std::uint32_t> local(mesh.vertex_count, 0);
  const auto use = [&](std::uint32_t vertex) {
    MeshData& part = parts.back();
    if (part_of[vertex] != parts.size()) {
      part_of[vertex] = static_cast<std::uint32_t>(parts.size());
      local[vertex] = part.vertex_count++;
      for (std::size_t s = 0; s < mesh.types.size(); ++s) {
        const auto size = static_cast<std::ptrdiff_t>(mesh.types[s].bytes());
        const auto from = mesh.data[s].begin() + static_cast<std::ptrdiff_t>(vertex) * size;
        part.data[s].insert(part.data[s].end(), from, from + size);
      }
    }
    part.indices.push_back(local[vertex]);
  };
  for (const IndexRange& range : mesh.ranges) {
    for (std::uint32_t i = 0; i < range.count; i += 3) {
      const std::uint32_t* corner = mesh.indices.data() + range.first + i;
      std::uint32_t fresh = 0;
      for (int c = 0; c < 3; ++c) fresh += part_of[corner[c]] != parts.size() ? 1u : 0u;
      if (parts.empty() || parts.back().vertex_count + fresh > max_vertices) {
        parts.emplace_back();
        parts.back().types = mesh.types;
        parts.back().data.resize(mesh.types.size());
      }
      MeshData& part = parts.back();
      if (part.ranges.empty() || i == 0)
        part.ranges.push_back({range.object, static_cast<std::uint32_t>(part.indices.size()), 0});
      for (int c = 0; c < 3; ++c) use(corner[c]);
      part.ranges.back().count += 3;
    }
  }
  return parts;
}

}  // namespace

std::uint32_t refine_ids(std::vector<std::uint32_t>& ids, std::span<const std::byte> bytes,
                         std::size_t size) {
  // Open addressing over the first row of each new id.
  const std::size_t capacity = std::bit_ceil(ids.size() * 2 + 1);
  std::vector<std::uint32_t> table(capacity, kUnset);
  std::vector<std::uint32_t> refined(ids.size());
  std::uint32_t next = 0;
  for (std::uint32_t row = 0; row < ids.size(); ++row) {
    const std::byte* value = bytes.data() + row * size;
    std::uint64_t hash = 0xcbf29ce484222325ULL ^ ids[row];
    for (std::size_t b = 0; b < size; b += 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, value + b, std::min<std::size_t>(8, size - b));
      hash = mix_bits(hash ^ word);
    }
    std::size_t at = hash & (capacity - 1);
    while (table[at] != kUnset) {
      const std::uint32_t other = table[at];
      if (ids[other] == ids[row] && std::memcmp(bytes.data() + other * size, value, size) == 0)
        break;
      at = (at + 1) & (capacity - 1);
    }
    if (table[at] == kUnset) {
      table[at] = row;
      refined[row] = next++;
    } else {
      refined[row] = refined[table[at]];
    }
  }
  ids = std::move(refined);
  return next;
}

std::vector<MeshData> build_meshes(std::vector<CornerStream> streams,
                                   std::vector<IndexRange> ranges, std::uint32_t max_vertices,
                                   std::vector<std::uint32_t> row_of) {
  LB_CHECK(!streams.empty(), "a mesh has positions");
  MeshData mesh;
  const std::size_t rows = streams.front().bytes.size() / streams.front().type.bytes();
  std::vector<std::uint32_t> vertex_of(rows, 0);
  mesh.ranges = std::move(ranges);
  std::size_t position_stream = 0;
  for (std::size_t s = 0; s < streams.size(); ++s) {
    const std::size_t size = streams[s].type.bytes();
    LB_CHECK(streams[s].bytes.size() == rows * size, "streams of equal length");
    mesh.vertex_count = refine_ids(vertex_of, streams[s].bytes, size);
    if (streams[s].type.name == "POSITION") position_stream = s;
  }
  for (CornerStream& s : streams) {
    const std::size_t size = s.type.bytes();
    Bytes unique(mesh.vertex_count * size);
    for (std::size_t r = 0; r < rows; ++r)
      std::memcpy(unique.data() + vertex_of[r] * size, s.bytes.data() + r * size, size);
    mesh.types.push_back(std::move(s.type));
    mesh.data.push_back(std::move(unique));
    s.bytes = {};
  }
  if (row_of.empty()) {
    mesh.indices = std::move(vertex_of);
  } else {
    mesh.indices = std::move(row_of);
    for (std::uint32_t& i : mesh.indices) i = vertex_of[i];
  }
  order_triangles(mesh, position_stream);
  order_vertices(mesh);
  if (mesh.vertex_count > max_vertices) return split(mesh, max_vertices);
  std::vector<MeshData> result;
  result.push_back(std::move(mesh));
  return result;
}

}  // namespace lightbatch::scene_out
