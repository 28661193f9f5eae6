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

const Json& view_of(const Document& document, const Json& part) {
  return document.json["bufferViews"][part["bufferView"].get<std::size_t>()];
}

bool lacks_data(const Document& document, const Json& part) {
  if (!part.contains("bufferView")) return false;
  const Json& view = view_of(document, part);
  return document.buffers[view["buffer"].get<std::size_t>()].size() <
         unsigned_field(view, "byteOffset") + unsigned_field(view, "byteLength");
}

/// The accessor itself or one of its sparse parts, when its buffer has no data; else nullptr.
const Json* part_without_data(const Document& document, const Json& accessor) {
  if (lacks_data(document, accessor)) return &accessor;
  const auto sparse = accessor.find("sparse");
  if (sparse == accessor.end()) return nullptr;
  for (const char* name : {"indices", "values"}) {
    if (lacks_data(document, (*sparse)[name])) return &(*sparse)[name];
  }
  return nullptr;
}

}  // namespace

std::string accessor_place(const Document& document, std::uint32_t accessor) {
  return document.name + "#/accessors/" + std::to_string(accessor);
}

const std::byte* view_data(const Document& document, const Json& part) {
  const Json& view = view_of(document, part);
  const Bytes& buffer = document.buffers[view["buffer"].get<std::size_t>()];
  return buffer.data() + unsigned_field(view, "byteOffset") + unsigned_field(part, "byteOffset");
}

Status check_data(const Document& document, std::uint32_t accessor, const JsonPath& user) {
  if (const Json* part = part_without_data(document, document.json["accessors"][accessor])) {
    return malformed(user.text(), "accessor " + std::to_string(accessor) + " is stored in buffer " +
                                      view_of(document, *part)["buffer"].dump() +
                                      ", which has no data");
  }
  return {};
}

Result<Elements> elements_of(const Document& document, std::uint32_t accessor) {
  const Json& json = document.json["accessors"][accessor];
  const std::optional<Layout> layout = layout_of(json);
  if (!layout) {
    return malformed(accessor_place(document, accessor), "the accessor has an unknown type");
  }
  if (part_without_data(document, json) != nullptr) {
    return malformed(accessor_place(document, accessor), "the accessor's buffer has no data");
  }
  Elements elements;
  elements.layout = *layout;
  if (json.contains("bufferView")) {
    const Json& view = view_of(document, json);
    elements.data = view_data(document, json);
    elements.stride = unsigned_field(view, "byteStride", layout->element_bytes);
  }
  return elements;
}

SparseLookup::SparseLookup(const Document& document, std::uint32_t accessor, const Layout& layout) {
  const Json& json = document.json["accessors"][accessor];
  const auto sparse = json.find("sparse");
  if (sparse == json.end()) return;
  indices_ = view_data(document, (*sparse)["indices"]);
  values_ = view_data(document, (*sparse)["values"]);
  index_bytes_ = component_bytes((*sparse)["indices"]["componentType"].get<std::uint32_t>());
  value_bytes_ = layout.element_bytes;
  count_ = (*sparse)["count"].get<std::uint64_t>();
}

const std::byte* SparseLookup::find(std::uint64_t element) const {
  std::uint64_t low = 0;
  std::uint64_t high = count_;
  while (low < high) {
    const std::uint64_t middle = low + (high - low) / 2;
    const std::uint64_t index = load_unsigned(indices_ + middle * index_bytes_, index_bytes_);
    if (index == element) return values_ + middle * value_bytes_;
    if (index < element) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return nullptr;
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

Status check_sparse_indices(const Document& document, std::uint64_t budget) {
  const Json& accessors = list_field(document.json, "accessors");
  for (std::uint32_t i = 0; i < accessors.size(); ++i) {
    const std::optional<Layout> layout = layout_of(accessors[i]);
    if (!layout || part_without_data(document, accessors[i]) != nullptr) continue;
    if (const auto sparse = accessors[i].find("sparse"); sparse != accessors[i].end()) {
      const std::uint64_t count = (*sparse)["count"].get<std::uint64_t>();
      if (count > budget) {
        return over_budget(accessor_place(document, i), "the scene has too many sparse values");
      }
      budget -= count;
    }
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
