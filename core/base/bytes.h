#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/status.h"

namespace lightbatch {

using Bytes = std::vector<std::byte>;

inline std::span<const std::byte> as_bytes(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}
inline std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Reads a whole file; IO_ERROR with the path on failure.
Result<Bytes> read_file(const std::filesystem::path& path);
/// Writes path atomically: a temporary file beside it, fsync, rename. A reader sees the old file,
/// the new file, or none; never a part.
Status write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);

}  // namespace lightbatch
