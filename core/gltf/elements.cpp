#include "core/gltf/elements.h"

#include <algorithm>
#include <optional>

namespace lightbatch::gltf {
namespace {

template <typename T>
std::uint32_t largest(const Elements& elements) {
  T value = 0;
  for (std::uint64_t i = 0; i < elements.layout.count; ++i) {
    value = std::max(value, load<T>(elements.data + i * elements.stride));
  }
  return value;
}

}  // namespace

std::string accessor_place(const Document& document, std::uint32_t accessor) {
  return document.name + "#/accessors/" + std::to_string(accessor);
}

const std::byte* view_data(const Document& document, const Json& part) {
  const Json& view = document.json["bufferViews"][part["bufferView"].get<std::size_t>()];
  const Bytes& buffer = document.buffers[view["buffer"].get<std::size_t>()];
  return buffer.data() + unsigned_field(view, "byteOffset") + unsigned_field(part, "byteOffset");
}

Result<Elements> elements_of(const Document& document, std::uint32_t accessor) {
  const Json& json = document.json["accessors"][accessor];
  const std::optional<Layout> layout = layout_of(json);
  if (!layout) {
    return malformed(accessor_place(document, accessor), "the accessor has an unknown type");
  }
  Elements elements;
  elements.layout = *layout;
  if (json.contains("bufferView")) {
    const Json& view = document.json["bufferViews"][json["bufferView"].get<std::size_t>()];
    elements.data = view_data(document, json);
    elements.stride = unsigned_field(view, "byteStride", layout->element_bytes);
  }
  return elements;
}

std::uint32_t largest_index(const Document& document, std::uint32_t accessor) {
  const Result<Elements> elements = elements_of(document, accessor);
  if (!elements.ok()) return 0;
  std::uint32_t value = 0;
  if (elements->data != nullptr) {
    const std::uint32_t bytes = elements->layout.component_bytes;
    value = bytes == 1   ? largest<std::uint8_t>(*elements)
            : bytes == 2 ? largest<std::uint16_t>(*elements)
                         : largest<std::uint32_t>(*elements);
  }
  for_each_sparse(
      document, accessor, elements->layout, [&](std::uint32_t, const std::byte* replacement) {
        value = std::max(value, load_unsigned(replacement, elements->layout.component_bytes));
      });
  return value;
}

Status check_sparse_indices(const Document& document) {
  const Json& accessors = list_field(document.json, "accessors");
  for (std::uint32_t i = 0; i < accessors.size(); ++i) {
    const std::optional<Layout> layout = layout_of(accessors[i]);
    if (!layout) continue;
    std::uint64_t least = 0;
    bool ascending = true;
    for_each_sparse(document, i, *layout, [&](std::uint32_t index, const std::byte*) {
      ascending = ascending && index >= least && index < layout->count;
      least = std::uint64_t{index} + 1;
    });
    if (!ascending) {
      return malformed(accessor_place(document, i) + "/sparse/indices",
                       "sparse indices must ascend and stay below the accessor's count");
    }
  }
  return {};
}

}  // namespace lightbatch::gltf
