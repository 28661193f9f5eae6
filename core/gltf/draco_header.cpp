#include "core/gltf/draco_header.h"

#include "core/base/bytes.h"

namespace lightbatch::gltf {
namespace {

constexpr std::uint16_t kMetadataFlag = 0x8000;
constexpr int kDeepestMetadata = 16;

/// A reader that, once past the end, stays there and says so.
class Cursor {
 public:
  explicit Cursor(std::span<const std::byte> bytes) : bytes_(bytes) {}

  bool ok() const { return ok_; }
  std::uint32_t byte() {
    if (offset_ >= bytes_.size()) {
      ok_ = false;
      return 0;
    }
    return std::to_integer<std::uint32_t>(bytes_[offset_++]);
  }
  /// LEB128, low bits first, 32 bits at most.
  std::uint32_t varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 35; shift += 7) {
      const std::uint32_t next = byte();
      value |= std::uint64_t{next & 0x7fu} << shift;
      if ((next & 0x80u) == 0) {
        if (value > 0xffffffffu) ok_ = false;
        return static_cast<std::uint32_t>(value);
      }
    }
    ok_ = false;
    return 0;
  }
  void skip(std::uint64_t count) {
    if (count > bytes_.size() - offset_) {
      ok_ = false;
    } else {
      offset_ += static_cast<std::size_t>(count);
    }
  }

 private:
  std::span<const std::byte> bytes_;
  std::size_t offset_ = 0;
  bool ok_ = true;
};

/// Each entry and sub-element takes at least one byte, so the loops end with the data.
void skip_metadata(Cursor& cursor, int depth) {
  if (depth > kDeepestMetadata) {
    cursor.skip(~std::uint64_t{0});
    return;
  }
  const std::uint32_t entries = cursor.varint();
  for (std::uint32_t i = 0; i < entries && cursor.ok(); ++i) {
    cursor.skip(cursor.byte());
    cursor.skip(cursor.varint());
  }
  const std::uint32_t parts = cursor.varint();
  for (std::uint32_t i = 0; i < parts && cursor.ok(); ++i) {
    cursor.skip(cursor.byte());
    skip_metadata(cursor, depth + 1);
  }
}

}  // namespace

bool is_draco(std::span<const std::byte> bytes) { return as_text(bytes).starts_with("DRACO"); }

Result<DracoCounts> read_draco_counts(std::span<const std::byte> stream, const std::string& place) {
  const Status cut_off = malformed(place, "broken Draco data: the stream ends in its header");
  if (!is_draco(stream)) return malformed(place, "broken Draco data: it does not begin with DRACO");
  Cursor cursor(stream);
  cursor.skip(5);
  const std::uint32_t major = cursor.byte();
  const std::uint32_t minor = cursor.byte();
  const std::uint32_t geometry = cursor.byte();
  const std::uint32_t method = cursor.byte();
  const std::uint32_t low = cursor.byte();
  const std::uint32_t flags = low | cursor.byte() << 8;
  if (!cursor.ok()) return cut_off;
  if (major != 2 || minor != 2) {
    return unsupported(place, "Draco bitstream version " + std::to_string(major) + "." +
                                  std::to_string(minor) + "; glTF uses version 2.2");
  }
  if (geometry == 0) return unsupported(place, "the Draco stream is a point cloud, not a mesh");
  if (geometry != 1 || method > 1) return malformed(place, "broken Draco data: unknown encoding");

  if ((flags & kMetadataFlag) != 0) {
    const std::uint32_t attributes = cursor.varint();
    for (std::uint32_t i = 0; i < attributes && cursor.ok(); ++i) {
      cursor.varint();
      skip_metadata(cursor, 0);
    }
    skip_metadata(cursor, 0);
  }

  DracoCounts counts;
  counts.edgebreaker = method == 1;
  if (counts.edgebreaker) {
    cursor.skip(1);  // traversal type
    counts.vertices = cursor.varint();
    counts.faces = cursor.varint();
    cursor.skip(1);  // number of attribute connectivities
    const std::uint32_t symbols = cursor.varint();
    const std::uint32_t splits = cursor.varint();
    if (cursor.ok() && (symbols > counts.faces || splits > symbols)) {
      return malformed(place, "broken Draco data: more symbols than faces");
    }
  } else {
    counts.faces = cursor.varint();
    counts.vertices = cursor.varint();
  }
  if (!cursor.ok()) return cut_off;
  return counts;
}

}  // namespace lightbatch::gltf
