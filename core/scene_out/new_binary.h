#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "core/base/bytes.h"
#include "core/gltf/document.h"
#include "core/scene_out/source_mesh.h"

namespace lightbatch::scene_out {

/// Collects the bytes that are written new, and appends their accessors and buffer views to the
/// JSON. Accessors of one stride share a view, so that a file of many small batches stays small.
/// Views refer to buffers first_buffer(), first_buffer() + 1, ... until the file is packed.
class NewBinary {
 public:
  NewBinary(gltf::Json& root, std::uint32_t first_buffer)
      : root_(root), first_buffer_(first_buffer) {}

  /// Packed elements of a vertex attribute; POSITION gets min and max, NORMAL and TANGENT of float
  /// become unit vectors. Returns the accessor.
  std::uint32_t add_attribute(const AttributeType& type, std::span<const std::byte> packed);
  /// Indices: 16 bits when all are below 65535, else 32. Returns the accessor.
  std::uint32_t add_indices(std::span<const std::uint32_t> indices);
  /// An accessor of floats outside vertex buffers (instance transforms). Returns the accessor.
  std::uint32_t add_instance_floats(std::span<const float> values, int components);
  /// A file kept whole (an image). Returns the buffer view.
  std::uint32_t add_file(std::span<const std::byte> bytes);

  /// The new buffers, in order; byteLength of every view is set here. Call once, at the end.
  std::vector<Bytes> finish();

 private:
  struct Stream {
    std::uint32_t view = 0;
    Bytes bytes;
  };
  std::uint32_t add_attribute_as_is(const AttributeType& type, std::span<const std::byte> packed);
  Stream& stream(std::uint32_t target, std::uint32_t stride);
  std::uint32_t add_accessor(Stream& stream, std::span<const std::byte> bytes, gltf::Json accessor);

  gltf::Json& root_;
  std::uint32_t first_buffer_;
  std::vector<Stream> streams_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> shared_;  // target, stride
};

}  // namespace lightbatch::scene_out
