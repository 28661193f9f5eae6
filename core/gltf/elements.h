#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "core/gltf/document.h"
#include "core/gltf/fields.h"
#include "core/gltf/layout.h"

/// Raw access to the elements of accessors that check_accessors() has accepted.
namespace lightbatch::gltf {

std::string accessor_place(const Document& document, std::uint32_t accessor);

/// Where a bufferView user's data (an accessor, or a sparse part) begins.
const std::byte* view_data(const Document& document, const Json& part);

template <typename T>
T load(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof(T));
  return value;
}

inline std::uint32_t load_unsigned(const std::byte* from, std::uint32_t bytes) {
  if (bytes == 1) return load<std::uint8_t>(from);
  if (bytes == 2) return load<std::uint16_t>(from);
  return load<std::uint32_t>(from);
}

/// The elements of an accessor as stored, sparse substitution aside.
struct Elements {
  Layout layout;
  const std::byte* data = nullptr;  // nullptr: all zero
  std::uint64_t stride = 0;
};

/// Buffers without data are allowed as long as nothing follows an accessor into them: this is the
/// question to ask before. INPUT_MALFORMED at `user` when the accessor has no bytes to read.
Status check_data(const Document& document, std::uint32_t accessor, const JsonPath& user);

/// INPUT_MALFORMED when the accessor's type is unknown, or its data missing.
Result<Elements> elements_of(const Document& document, std::uint32_t accessor);

/// Calls use(element index, bytes of the replacement) for each sparse value.
template <typename Use>
void for_each_sparse(const Document& document, std::uint32_t accessor, const Layout& layout,
                     Use use) {
  const Json& json = document.json["accessors"][accessor];
  const auto sparse = json.find("sparse");
  if (sparse == json.end()) return;
  const std::uint32_t index_bytes =
      component_bytes((*sparse)["indices"]["componentType"].get<std::uint32_t>());
  const std::byte* indices = view_data(document, (*sparse)["indices"]);
  const std::byte* values = view_data(document, (*sparse)["values"]);
  const std::uint64_t count = (*sparse)["count"].get<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) {
    use(load_unsigned(indices + i * index_bytes, index_bytes), values + i * layout.element_bytes);
  }
}

/// Finds the sparse replacement of an element, by bisection.
class SparseLookup {
 public:
  SparseLookup(const Document& document, std::uint32_t accessor, const Layout& layout);
  /// nullptr when the element is not replaced.
  const std::byte* find(std::uint64_t element) const;

 private:
  const std::byte* indices_ = nullptr;
  const std::byte* values_ = nullptr;
  std::uint32_t index_bytes_ = 0;
  std::uint32_t value_bytes_ = 0;
  std::uint64_t count_ = 0;
};

/// The largest value of an accessor of unsigned scalars.
std::uint32_t largest_index(const Document& document, std::uint32_t accessor);

/// Sparse indices ascend and stay below the number of elements. At most `budget` of them are looked
/// at: accessors may share the same bytes any number of times.
Status check_sparse_indices(const Document& document, std::uint64_t budget);

}  // namespace lightbatch::gltf
