#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/gltf/document.h"
#include "core/gltf/json_path.h"

namespace lightbatch::gltf {

/// Bytes of a component type (glTF 3.6.2.2); 0 for an unknown one.
std::uint32_t component_bytes(std::uint32_t component_type);

/// How the elements of an accessor lie in memory. Matrices of small components have columns padded
/// to 4 bytes (3.6.2.4); element_bytes counts the padding.
struct Layout {
  std::uint32_t component_type = 0;
  std::uint32_t component_bytes = 0;
  std::uint32_t components = 0;  // of the whole element
  std::uint32_t rows = 0;        // components of a column; components when not a matrix
  std::uint32_t column_bytes = 0;
  std::uint32_t element_bytes = 0;
  std::uint64_t count = 0;
  bool normalized = false;
};

/// nullopt when the accessor's type is none of SCALAR .. MAT4.
std::optional<Layout> layout_of(const Json& accessor);

/// Scalars of an unsigned integer type.
bool is_index_layout(const Layout& layout);

/// Every buffer view lies within its buffer.
Status check_buffer_views(const Json& json, const JsonPath& root,
                          std::vector<std::string>& warnings);

/// Every accessor (and its sparse parts) lies within its view, aligned as 3.6.2.4 demands. Adds
/// what accessors without a view would take in memory to *zero_bytes.
Status check_accessors(const Json& json, const JsonPath& root, std::uint64_t* zero_bytes,
                       std::vector<std::string>& warnings);

}  // namespace lightbatch::gltf
