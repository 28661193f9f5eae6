#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/gltf/document.h"

namespace lightbatch::gltf {

/// Component values of an accessor of a validated document, sparse substitution done, normalised
/// integers mapped as glTF 3.6.2.2 says. components: 1..16 by the accessor's type.
struct Values {
  int components = 0;
  std::vector<float> data;  // count * components
  std::size_t count() const {
    return components == 0 ? 0 : data.size() / static_cast<std::size_t>(components);
  }
};

/// INPUT_MALFORMED when a value is not finite (the place names the accessor).
Result<Values> read_values(const Document& document, std::uint32_t accessor);

/// The same for some elements only, in the order asked for; each below the accessor's count.
Result<Values> read_elements(const Document& document, std::uint32_t accessor,
                             std::span<const std::uint32_t> elements);

/// Unsigned integers (indices, joints); INPUT_MALFORMED when the accessor is not of an unsigned
/// scalar type.
Result<std::vector<std::uint32_t>> read_indices(const Document& document, std::uint32_t accessor);

/// Accessor bytes as stored, tightly packed (stride removed, sparse applied): what a writer copies
/// to keep a component type as it was.
Result<Bytes> read_packed(const Document& document, std::uint32_t accessor);

}  // namespace lightbatch::gltf
