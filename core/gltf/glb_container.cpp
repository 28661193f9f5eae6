#include "core/gltf/glb_container.h"

#include <cstdint>

#include "core/base/bytes.h"

namespace lightbatch::gltf {
namespace {

constexpr std::uint32_t kJsonChunk = 0x4e4f534a;    // "JSON"
constexpr std::uint32_t kBinaryChunk = 0x004e4942;  // "BIN\0"
constexpr std::size_t kHeaderBytes = 12;
constexpr std::size_t kChunkHeaderBytes = 8;

std::uint32_t read_u32(std::span<const std::byte> bytes, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) {
    value = value << 8 | std::to_integer<std::uint32_t>(bytes[offset + i]);
  }
  return value;
}

}  // namespace

bool is_glb(std::span<const std::byte> file) { return as_text(file).starts_with("glTF"); }

Result<GlbChunks> split_glb(std::span<const std::byte> file, const std::string& place) {
  const auto fail = [&place](std::size_t offset, const std::string& message) {
    return malformed(place + "@" + std::to_string(offset), "broken GLB: " + message);
  };
  if (file.size() < kHeaderBytes) return fail(file.size(), "the file ends within its header");
  const std::uint32_t version = read_u32(file, 4);
  if (version == 0) return fail(4, "container version 0");
  if (version != 2) {
    return unsupported(place + "@4", "GLB container version " + std::to_string(version) +
                                         "; only version 2 can be read");
  }
  const std::uint32_t length = read_u32(file, 8);
  if (length != file.size()) {
    return fail(8, "the header says " + std::to_string(length) + " bytes, the file has " +
                       std::to_string(file.size()));
  }

  GlbChunks chunks;
  bool json_seen = false;
  std::size_t index = 0;
  for (std::size_t offset = kHeaderBytes; offset < file.size(); ++index) {
    if (file.size() - offset < kChunkHeaderBytes) {
      return fail(offset, "the file ends within a chunk header");
    }
    const std::size_t size = read_u32(file, offset);
    const std::uint32_t type = read_u32(file, offset + 4);
    if (size % 4 != 0) {
      return fail(offset,
                  "the length of a chunk (" + std::to_string(size) + ") must be a multiple of 4");
    }
    if (size > file.size() - offset - kChunkHeaderBytes) {
      return fail(offset, "a chunk of " + std::to_string(size) + " bytes runs past the end");
    }
    if ((index == 0) != (type == kJsonChunk)) {
      return fail(offset + 4, index == 0 ? "the first chunk must be JSON" : "a second JSON chunk");
    }
    if (type == kBinaryChunk && index != 1) return fail(offset + 4, "BIN must be the second chunk");
    const std::size_t start = offset + kChunkHeaderBytes;
    if (type == kJsonChunk) {
      chunks.json = as_text(file.subspan(start, size));
      chunks.json_offset = start;
      json_seen = true;
    } else if (type == kBinaryChunk) {
      chunks.binary = file.subspan(start, size);
    }
    offset = start + size;
  }
  if (!json_seen) return fail(kHeaderBytes, "there is no JSON chunk");
  return chunks;
}

}  // namespace lightbatch::gltf
