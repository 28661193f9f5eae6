#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/status.h"
#include "core/gltf/document.h"
#include "core/math/vec.h"
#include "core/scene/scene.h"

namespace lightbatch::scene_out {

/// How one vertex attribute is stored.
struct AttributeType {
  std::string name;  // POSITION, NORMAL, TEXCOORD_0, _CUSTOM...
  int component_type = 5126;
  bool normalized = false;
  std::string type = "VEC3";
  int components = 3;

  std::size_t component_bytes() const;
  std::size_t bytes() const { return component_bytes() * static_cast<std::size_t>(components); }
  bool operator==(const AttributeType&) const = default;
};

/// Attributes of a primitive, by name. POSITION is among them.
std::vector<AttributeType> attribute_types(const gltf::Json& root, const gltf::Json& primitive);

/// A primitive of triangles as stored: packed attribute bytes and its own list of triangles (strips
/// and fans unrolled as glTF 3.7.2.1 says; degenerate ones included).
struct SourcePrimitive {
  std::vector<AttributeType> types;
  std::vector<Bytes> data;             // one per type
  std::vector<Vec3f> positions;        // decoded
  std::vector<std::uint32_t> corners;  // 3 for each triangle
  std::uint32_t vertex_count() const { return static_cast<std::uint32_t>(positions.size()); }
};

/// Primitives read once each.
class SourceMeshes {
 public:
  explicit SourceMeshes(const gltf::Document& document) : document_(document) {}
  Result<const SourcePrimitive*> get(std::uint32_t mesh, std::uint32_t primitive);

 private:
  const gltf::Document& document_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::unique_ptr<SourcePrimitive>> read_;
};

}  // namespace lightbatch::scene_out
