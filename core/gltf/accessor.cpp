#include "core/gltf/accessor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "core/gltf/elements.h"

namespace lightbatch::gltf {
namespace {

/// glTF 3.6.2.2: signed values map -1..1 with both smallest numbers at -1.
template <typename T>
float component_value(const std::byte* from, bool normalized) {
  const T raw = load<T>(from);
  if constexpr (std::is_same_v<T, float>) {
    return raw;
  } else {
    const auto value = static_cast<double>(raw);
    if (!normalized || sizeof(T) == 4) return static_cast<float>(value);
    constexpr auto kScale = static_cast<double>(std::numeric_limits<T>::max());
    return static_cast<float>(std::max(value / kScale, -1.0));
  }
}

template <typename T>
void convert_element(const Layout& layout, const std::byte* from, float* to) {
  const std::uint32_t columns = layout.components / layout.rows;
  for (std::uint32_t c = 0; c < columns; ++c) {
    for (std::uint32_t r = 0; r < layout.rows; ++r) {
      *to++ = component_value<T>(from + c * layout.column_bytes + r * sizeof(T), layout.normalized);
    }
  }
}

/// Converts the elements at(0), at(1)... at(count - 1); sparse values are looked up for each.
template <typename T, typename At>
void convert_all(const Document& document, std::uint32_t accessor, const Elements& elements,
                 std::size_t count, At at, std::vector<float>& out) {
  const Layout& layout = elements.layout;
  const SparseLookup sparse(document, accessor, layout);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t element = at(i);
    const std::byte* from = sparse.find(element);
    if (from == nullptr && elements.data != nullptr)
      from = elements.data + element * elements.stride;
    if (from != nullptr) convert_element<T>(layout, from, out.data() + i * layout.components);
  }
}

template <typename At>
Result<Values> convert(const Document& document, std::uint32_t accessor, const Elements& elements,
                       std::size_t count, At at) {
  Values values;
  values.components = static_cast<int>(elements.layout.components);
  values.data.resize(count * elements.layout.components);
  std::vector<float>& out = values.data;
  switch (elements.layout.component_type) {
    case 5120:
      convert_all<std::int8_t>(document, accessor, elements, count, at, out);
      break;
    case 5121:
      convert_all<std::uint8_t>(document, accessor, elements, count, at, out);
      break;
    case 5122:
      convert_all<std::int16_t>(document, accessor, elements, count, at, out);
      break;
    case 5123:
      convert_all<std::uint16_t>(document, accessor, elements, count, at, out);
      break;
    case 5125:
      convert_all<std::uint32_t>(document, accessor, elements, count, at, out);
      break;
    default:
      convert_all<float>(document, accessor, elements, count, at, out);
      break;
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (std::isfinite(out[i])) continue;
    return malformed(accessor_place(document, accessor),
                     "element " + std::to_string(at(i / elements.layout.components)) +
                         " of the accessor is not finite");
  }
  return values;
}

}  // namespace

Result<Values> read_values(const Document& document, std::uint32_t accessor) {
  LB_ASSIGN_OR_RETURN(const Elements elements, elements_of(document, accessor));
  return convert(document, accessor, elements, elements.layout.count,
                 [](std::size_t i) { return i; });
}

Result<Values> read_elements(const Document& document, std::uint32_t accessor,
                             std::span<const std::uint32_t> wanted) {
  LB_ASSIGN_OR_RETURN(const Elements elements, elements_of(document, accessor));
  for (const std::uint32_t element : wanted) {
    LB_CHECK(element < elements.layout.count, "the caller has checked the elements it asks for");
  }
  return convert(document, accessor, elements, wanted.size(),
                 [wanted](std::size_t i) { return wanted[i]; });
}

Result<std::vector<std::uint32_t>> read_indices(const Document& document, std::uint32_t accessor) {
  LB_ASSIGN_OR_RETURN(const Elements elements, elements_of(document, accessor));
  const Layout& layout = elements.layout;
  if (!is_index_layout(layout)) {
    return malformed(accessor_place(document, accessor), "the accessor is not of unsigned scalars");
  }
  std::vector<std::uint32_t> indices(layout.count);
  if (elements.data != nullptr) {
    for (std::uint64_t i = 0; i < layout.count; ++i) {
      indices[i] = load_unsigned(elements.data + i * elements.stride, layout.component_bytes);
    }
  }
  for_each_sparse(document, accessor, layout, [&](std::uint32_t index, const std::byte* value) {
    indices[index] = load_unsigned(value, layout.component_bytes);
  });
  return indices;
}

Result<Bytes> read_packed(const Document& document, std::uint32_t accessor) {
  LB_ASSIGN_OR_RETURN(const Elements elements, elements_of(document, accessor));
  const std::uint32_t size = elements.layout.element_bytes;
  Bytes packed(elements.layout.count * size);
  if (elements.data != nullptr) {
    if (elements.stride == size) {
      std::memcpy(packed.data(), elements.data, packed.size());
    } else {
      for (std::uint64_t i = 0; i < elements.layout.count; ++i) {
        std::memcpy(packed.data() + i * size, elements.data + i * elements.stride, size);
      }
    }
  }
  for_each_sparse(document, accessor, elements.layout,
                  [&](std::uint32_t index, const std::byte* value) {
                    std::memcpy(packed.data() + std::size_t{index} * size, value, size);
                  });
  return packed;
}

}  // namespace lightbatch::gltf
