#include "core/gltf/glb_writer.h"

#include <array>
#include <limits>
#include <string>

#include "core/gltf/json_text.h"

namespace lightbatch::gltf {
namespace {

void append(Bytes& out, std::span<const std::byte> bytes) {
  out.insert(out.end(), bytes.begin(), bytes.end());
}

void append_u32(Bytes& out, std::uint64_t value) {
  for (int shift = 0; shift < 32; shift += 8) {
    out.push_back(static_cast<std::byte>(value >> shift & 0xff));
  }
}

std::uint64_t padded(std::uint64_t size) { return (size + 3) / 4 * 4; }

}  // namespace

Result<Bytes> write_glb(Json json, std::span<const std::byte> binary) {
  if (!binary.empty()) json["buffers"][0]["byteLength"] = binary.size();
  LB_ASSIGN_OR_RETURN(const std::string text, write_json(json));
  std::uint64_t length = 12 + 8 + padded(text.size());
  if (!binary.empty()) length += 8 + padded(binary.size());
  if (length > std::numeric_limits<std::uint32_t>::max()) {
    return over_budget("glb", "the scene takes " + std::to_string(length) +
                                  " bytes; a .glb file holds at most 4 GiB");
  }
  Bytes out;
  out.reserve(length);
  append(out, as_bytes("glTF"));
  append_u32(out, 2);
  append_u32(out, length);
  append_u32(out, padded(text.size()));
  append(out, as_bytes("JSON"));
  append(out, as_bytes(text));
  out.resize(20 + padded(text.size()), std::byte{' '});
  if (!binary.empty()) {
    append_u32(out, padded(binary.size()));
    append(out, as_bytes(std::string_view("BIN\0", 4)));
    append(out, binary);
    out.resize(length, std::byte{0});
  }
  return out;
}

}  // namespace lightbatch::gltf
