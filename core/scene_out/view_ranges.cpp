#include "core/scene_out/view_ranges.h"

#include <algorithm>

#include "core/scene_out/json_access.h"

namespace lightbatch::scene_out {
namespace {

constexpr std::uint64_t kAlign = 4;

std::uint64_t number_at(const Json& json, const char* key) {
  const Json* value = member(json, key);
  return value != nullptr && value->is_number_integer() ? value->get<std::uint64_t>() : 0;
}

std::uint64_t component_bytes(std::uint64_t type) {
  return type == 5120 || type == 5121 ? 1 : type == 5122 || type == 5123 ? 2 : 4;
}

/// Columns of matrices of small components are padded to 4 bytes (glTF 3.6.2.4).
std::uint64_t element_bytes(const Json& accessor) {
  const std::string type = accessor.value("type", "SCALAR");
  const std::uint64_t size = component_bytes(number_at(accessor, "componentType"));
  if (type == "MAT2") return size == 1 ? 8 : 4 * size;
  if (type == "MAT3") return size == 1 ? 12 : size == 2 ? 24 : 36;
  if (type == "MAT4") return 16 * size;
  return size * (type == "SCALAR" ? 1 : type == "VEC2" ? 2 : type == "VEC3" ? 3 : 4);
}

/// Calls visit(json, bytes) for every object with a bufferView and a byteOffset into it: accessors
/// and their sparse parts; bytes as read from the offset on, without stride when packed.
template <typename Visit>
void for_each_read(Json& root, const std::vector<std::uint64_t>& stride, const Visit& visit) {
  Json* accessors = member(root, "accessors");
  if (accessors == nullptr) return;
  for (Json& accessor : *accessors) {
    const std::uint64_t count = number_at(accessor, "count");
    const std::uint64_t size = element_bytes(accessor);
    if (const std::uint32_t view = index_at(accessor, "bufferView"); view < stride.size()) {
      const std::uint64_t step = stride[view] == 0 ? size : stride[view];
      visit(accessor, count == 0 ? 0 : (count - 1) * step + std::max(size, stride[view]));
    }
    if (Json* sparse = member(accessor, "sparse")) {
      const std::uint64_t changed = number_at(*sparse, "count");
      if (Json* indices = member(*sparse, "indices"))
        visit(*indices, changed * component_bytes(number_at(*indices, "componentType")));
      if (Json* values = member(*sparse, "values")) visit(*values, changed * size);
    }
  }
}

/// Calls visit(slot) for the view of every Draco stream.
template <typename Visit>
void for_each_stream(Json& root, const Visit& visit) {
  Json* meshes = member(root, "meshes");
  if (meshes == nullptr) return;
  for (Json& mesh : *meshes)
    for (Json& primitive : mesh["primitives"])
      if (Json* extensions = member(primitive, "extensions"))
        if (Json* draco = member(*extensions, "KHR_draco_mesh_compression"))
          visit((*draco)["bufferView"]);
}

}  // namespace

void for_each_view(Json& root, const std::function<void(Json&)>& visit) {
  const auto in = [&](Json& json) {
    if (Json* slot = member(json, "bufferView")) visit(*slot);
  };
  if (Json* accessors = member(root, "accessors"))
    for (Json& accessor : *accessors) {
      in(accessor);
      if (Json* sparse = member(accessor, "sparse"))
        for (const char* part : {"indices", "values"})
          if (Json* json = member(*sparse, part)) in(*json);
    }
  if (Json* images = member(root, "images"))
    for (Json& image : *images) in(image);
  for_each_stream(root, visit);
}

ViewUses::ViewUses(Json& root, const std::set<std::uint32_t>& pinned) {
  for (const Json& view : root["bufferViews"]) {
    length_.push_back(number_at(view, "byteLength"));
    stride_.push_back(number_at(view, "byteStride"));
  }
  whole_.assign(length_.size(), false);
  ranges_.resize(length_.size());
  for (const std::uint32_t v : pinned)
    if (v < whole_.size()) whole_[v] = true;
  if (const Json* images = member(root, "images"))
    for (const Json& image : *images)
      if (const std::uint32_t v = index_at(image, "bufferView"); v < whole_.size())
        whole_[v] = true;
  for_each_stream(root, [&](const Json& slot) { whole_.at(slot.get<std::size_t>()) = true; });
  for_each_read(root, stride_, [&](Json& json, std::uint64_t bytes) { add(json, bytes); });
  for (std::size_t v = 0; v < ranges_.size(); ++v) {
    auto& ranges = ranges_[v];
    if (whole_[v]) ranges = {{0, length_[v], 0}};
    std::sort(ranges.begin(), ranges.end(),
              [](const Range& a, const Range& b) { return a.begin < b.begin; });
    std::vector<Range> merged;
    for (const Range& r : ranges) {
      if (!merged.empty() && r.begin <= merged.back().end)
        merged.back().end = std::max(merged.back().end, r.end);
      else
        merged.push_back(r);
    }
    ranges = std::move(merged);
  }
}

void ViewUses::add(Json& json, std::uint64_t bytes) {
  const std::uint32_t view = index_at(json, "bufferView");
  if (view >= ranges_.size()) return;
  const std::uint64_t offset = number_at(json, "byteOffset");
  const std::uint64_t unit = std::max(kAlign, stride_[view]);
  // Whole strides stay together: readers of interleaved views count on it.
  const std::uint64_t begin = offset / unit * unit;
  const std::uint64_t end = std::min(length_[view], (offset + bytes + unit - 1) / unit * unit);
  ranges_[view].push_back({begin, std::max(begin, end), 0});
}

Bytes ViewUses::copy_ranges(Json& root, std::span<const Bytes* const> buffers) {
  Bytes binary;
  Json& views = root["bufferViews"];
  for (std::uint32_t v = 0; v < ranges_.size(); ++v) {
    if (!is_used(v)) continue;
    Json& view = views[v];
    const Bytes& source = *buffers[index_at(view, "buffer")];
    const std::uint64_t base = number_at(view, "byteOffset");
    binary.resize((binary.size() + kAlign - 1) / kAlign * kAlign);
    const std::uint64_t start = binary.size();
    for (Range& r : ranges_[v]) {
      // Ranges begin at whole strides and lengths are kept, so offsets stay aligned.
      r.moved_to = binary.size() - start;
      const auto from = source.begin() + static_cast<std::ptrdiff_t>(base + r.begin);
      binary.insert(binary.end(), from, from + static_cast<std::ptrdiff_t>(r.end - r.begin));
      const std::uint64_t unit = std::max(kAlign, stride_[v]);
      if (&r != &ranges_[v].back())
        binary.resize(start + (binary.size() - start + unit - 1) / unit * unit);
    }
    view["buffer"] = 0;
    view["byteLength"] = binary.size() - start;
    if (start == 0)
      view.erase("byteOffset");
    else
      view["byteOffset"] = start;
  }
  for_each_read(root, stride_, [&](Json& json, std::uint64_t) {
    const std::uint32_t view = index_at(json, "bufferView");
    const std::uint64_t offset = number_at(json, "byteOffset");
    auto it = std::upper_bound(ranges_[view].begin(), ranges_[view].end(), offset,
                               [](std::uint64_t o, const Range& r) { return o < r.begin; });
    if (it == ranges_[view].begin()) return;
    --it;
    const std::uint64_t moved = offset - it->begin + it->moved_to;
    if (moved == 0)
      json.erase("byteOffset");
    else
      json["byteOffset"] = moved;
  });
  return binary;
}

}  // namespace lightbatch::scene_out
