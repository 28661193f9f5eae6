#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/gltf/document.h"
#include "core/math/vec.h"
#include "core/scene/scene.h"

namespace lightbatch::scene_in {

/// Triangles of one primitive in object space: only the vertices they use, in ascending order of
/// their number in the file; strips and fans taken apart.
struct Primitive {
  std::vector<Vec3f> positions;
  std::vector<Vec2f> uv0;  // empty when the primitive has none, or nobody asked
  std::vector<Vec2f> uv1;
  std::vector<scene::VertexColor> colors;  // empty when the primitive has none
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// "" when the primitive can be lit; otherwise why not: "LINES", "POINTS", "no positions".
std::string undrawable(const gltf::Json& primitive);

/// Triangles the primitive stands for, degenerate ones included.
std::uint64_t triangle_count(const gltf::Document& document, const gltf::Json& primitive);

struct PrimitiveNeeds {
  bool uv0 = false;
  bool uv1 = false;
};
/// INPUT_MALFORMED when a vertex it uses is not finite (the place names the accessor).
Result<Primitive> read_primitive(const gltf::Document& document, const gltf::Json& primitive,
                                 PrimitiveNeeds needs);

}  // namespace lightbatch::scene_in
