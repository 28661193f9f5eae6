#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "core/base/status.h"

namespace lightbatch::gltf {

/// What a Draco stream says of itself before its entropy-coded part.
struct DracoCounts {
  std::uint32_t faces = 0;
  std::uint32_t vertices = 0;  // of the connectivity; seams may make more points of them
  bool edgebreaker = false;    // false: sequential, where vertices are the points
};

/// Reads the counts of a Draco mesh (Draco bitstream specification 2.2: header, metadata,
/// connectivity header) without decoding it, so that a decoder can be held to them before it
/// allocates. INPUT_MALFORMED for a damaged head, INPUT_UNSUPPORTED for point clouds and other
/// bitstream versions.
Result<DracoCounts> read_draco_counts(std::span<const std::byte> stream, const std::string& place);

/// True for the first bytes of a bare Draco file.
bool is_draco(std::span<const std::byte> bytes);

}  // namespace lightbatch::gltf
