#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/gltf/layout.h"

namespace lightbatch::gltf {

/// Where one attribute of a Draco mesh goes: `layout.count` elements, `stride` bytes apart.
struct DracoAttribute {
  std::uint32_t unique_id = 0;
  std::string name;
  Layout layout;
  std::uint64_t stride = 0;
  std::byte* out = nullptr;
};

/// Where its corners go: 3 per face, as unsigned integers of `index_bytes`.
struct DracoIndices {
  std::uint64_t count = 0;
  std::uint32_t index_bytes = 4;
  std::byte* out = nullptr;
};

/// Holds the stream's own counts against those of the accessors, and both against its length. To be
/// done before anything is allocated for either; the decoder allocates what the stream says.
Status check_draco_counts(std::span<const std::byte> stream, const std::string& place,
                          std::uint64_t points, std::uint64_t index_count);

/// Decodes one Draco mesh, which check_draco_counts() has accepted, into memory whose sizes the
/// caller took from the accessors. Thread-safe. Nothing is promised about the memory when it fails.
Status decode_draco_mesh(std::span<const std::byte> stream, const std::string& place,
                         std::span<const DracoAttribute> attributes, const DracoIndices& indices);

}  // namespace lightbatch::gltf
