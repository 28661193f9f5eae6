// Vertex codec version 0 and index codec version 1 of meshoptimizer, as EXT_meshopt_compression
// asks.
#include "core/scene_out/meshopt_encode.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <vector>

#include "core/scene_out/json_access.h"
#include "core/scene_out/references.h"

namespace lightbatch::scene_out {
namespace {

constexpr const char* kMeshopt = "EXT_meshopt_compression";
constexpr std::uint64_t kVertices = 34962, kIndices = 34963;

std::uint64_t number_at(const Json& json, const char* key) {
  const Json* value = member(json, key);
  return value != nullptr && value->is_number_integer() ? value->get<std::uint64_t>() : 0;
}

/// Bytes of an index, by view: 2 or 4 where all accessors of a view agree, 0 elsewhere.
std::vector<std::size_t> index_sizes(const Json& root) {
  std::vector<std::size_t> sizes(count_of(root, "bufferViews"), 0);
  std::vector<bool> mixed(sizes.size(), false);
  for (const Json& accessor : root.at("accessors")) {
    const std::uint32_t view = index_at(accessor, "bufferView");
    if (view >= sizes.size()) continue;
    const std::uint64_t type = number_at(accessor, "componentType");
    const std::size_t size = type == 5123 ? 2 : type == 5125 ? 4 : 0;
    mixed[view] = mixed[view] || size == 0 || (sizes[view] != 0 && sizes[view] != size);
    sizes[view] = size;
  }
  for (std::size_t v = 0; v < sizes.size(); ++v)
    if (mixed[v]) sizes[v] = 0;
  return sizes;
}

Bytes encode_vertices(const std::byte* data, std::size_t count, std::size_t stride) {
  meshopt_encodeVertexVersion(0);
  Bytes out(meshopt_encodeVertexBufferBound(count, stride));
  out.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(out.data()), out.size(),
                                        data, count, stride));
  return out;
}

Bytes encode_indices(const std::byte* data, std::size_t count, std::size_t size) {
  meshopt_encodeIndexVersion(1);
  std::vector<unsigned> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t value = 0;
    std::memcpy(&value, data + i * size, size);
    values[i] = value;
  }
  const unsigned largest = values.empty() ? 0 : *std::max_element(values.begin(), values.end());
  Bytes out(meshopt_encodeIndexSequenceBound(count, std::size_t{largest} + 1));
  out.resize(meshopt_encodeIndexSequence(reinterpret_cast<unsigned char*>(out.data()), out.size(),
                                         values.data(), count));
  return out;
}

}  // namespace

Bytes compress_views(Json& root, const Json& before, Bytes binary) {
  if (!root.contains("accessors") || !root.contains("bufferViews")) return binary;
  const std::set<std::uint32_t> pinned = find_pins(before).views;
  const std::vector<std::size_t> sizes = index_sizes(root);
  Bytes packed;
  std::uint64_t plain = 0;  // bytes of the buffer that exists after decoding only
  Json& views = root["bufferViews"];
  for (std::uint32_t v = 0; v < views.size(); ++v) {
    Json& view = views[v];
    const std::uint64_t offset = number_at(view, "byteOffset");
    const std::uint64_t length = number_at(view, "byteLength");
    const std::uint64_t target = pinned.contains(v) ? 0 : number_at(view, "target");
    const std::byte* data = binary.data() + offset;
    Bytes encoded;
    std::size_t stride = 0;
    if (target == kVertices) {
      stride = number_at(view, "byteStride");
      if (stride != 0 && stride % 4 == 0 && stride <= 256 && length % stride == 0)
        encoded = encode_vertices(data, length / stride, stride);
    } else if (target == kIndices) {
      stride = sizes[v];
      if (stride != 0 && length % stride == 0)
        encoded = encode_indices(data, length / stride, stride);
    }
    packed.resize((packed.size() + 3) / 4 * 4);
    const std::uint64_t at = packed.size();
    if (encoded.empty() || encoded.size() >= length) {
      packed.insert(packed.end(), data, data + length);
      view["byteOffset"] = at;
      continue;
    }
    packed.insert(packed.end(), encoded.begin(), encoded.end());
    view["extensions"][kMeshopt] = {{"buffer", 0},
                                    {"byteOffset", at},
                                    {"byteLength", encoded.size()},
                                    {"byteStride", stride},
                                    {"count", length / stride},
                                    {"mode", target == kVertices ? "ATTRIBUTES" : "INDICES"}};
    plain = (plain + 3) / 4 * 4;
    view["buffer"] = 1;
    view["byteOffset"] = plain;
    plain += length;
  }
  if (plain == 0) return binary;
  root["buffers"][0]["byteLength"] = packed.size();
  root["buffers"].push_back(
      Json{{"byteLength", plain}, {"extensions", {{kMeshopt, {{"fallback", true}}}}}});
  declare_extension(root, "extensionsUsed", kMeshopt);
  declare_extension(root, "extensionsRequired", kMeshopt);
  return packed;
}

}  // namespace lightbatch::scene_out
