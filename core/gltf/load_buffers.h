#pragma once

#include <optional>
#include <string>

#include "core/gltf/document.h"
#include "core/gltf/json_path.h"
#include "core/gltf/uri.h"

namespace lightbatch::gltf {

/// Where the bytes of buffers and images come from: files of the map, data uris, the GLB's binary
/// chunk. Counts all bytes against ReadLimits::decoded_bytes.
class ResourceLoader {
 public:
  ResourceLoader(const FileMap& files, const std::string& main, std::uint64_t budget);

  /// Bytes behind a uri of the scene.
  Result<Bytes> load(const std::string& uri, const JsonPath& path, std::string* media_type);
  Status spend(std::uint64_t bytes, const std::string& place);
  std::uint64_t file_bytes() const { return file_bytes_; }

 private:
  const FileMap& files_;
  std::string folder_;
  std::uint64_t budget_;
  std::uint64_t spent_ = 0;
  std::uint64_t file_bytes_ = 0;
};

/// Fills document.buffers. A buffer without data (no uri, and not the GLB's own) stays empty, as do
/// a meshopt fallback buffer and one with a forbidden uri that no bufferView uses.
Status load_buffers(Document& document, const JsonPath& root, std::optional<Bytes> binary, bool glb,
                    ResourceLoader& loader);

}  // namespace lightbatch::gltf
