#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/base/status.h"

namespace lightbatch::gltf {

bool is_glb(std::span<const std::byte> file);

/// The two chunks of a .glb; both point into the file's bytes.
struct GlbChunks {
  std::string_view json;
  std::size_t json_offset = 0;
  std::optional<std::span<const std::byte>> binary;
};

/// Checks every length, alignment and order that glTF 2.0, chapter 4 lays down. INPUT_MALFORMED
/// with the byte offset; INPUT_UNSUPPORTED for another container version.
Result<GlbChunks> split_glb(std::span<const std::byte> file, const std::string& place);

}  // namespace lightbatch::gltf
