#include "core/scene_in/primitive.h"

#include <algorithm>
#include <cmath>

#include "core/gltf/accessor.h"
#include "core/gltf/fields.h"

namespace lightbatch::scene_in {
namespace {

using gltf::Json;
using gltf::kAbsent;
using Corners = std::array<std::uint32_t, 3>;

enum Mode : std::uint64_t { kTriangles = 4, kStrip = 5, kFan = 6 };

/// Numbers of the corners, before strips and fans are taken apart.
std::uint64_t corner_count(const gltf::Document& document, const Json& primitive) {
  std::uint32_t accessor = gltf::index_field(primitive, "indices");
  if (accessor == kAbsent) accessor = gltf::index_field(primitive["attributes"], "POSITION");
  return document.json["accessors"][accessor]["count"].get<std::uint64_t>();
}

/// glTF 3.7.2.1: vertices of triangle i of a list, a strip and a fan.
Corners corners_of(std::uint64_t mode, std::uint32_t i) {
  if (mode == kStrip) return {i, i + 1 + i % 2, i + 2 - i % 2};
  if (mode == kFan) return {i + 1, i + 2, 0};
  return {3 * i, 3 * i + 1, 3 * i + 2};
}

/// Renumbers the corners so that only used vertices remain; returns the old numbers, ascending.
std::vector<std::uint32_t> compact(std::vector<Corners>& triangles, std::uint32_t vertices) {
  std::vector<std::uint32_t> used;
  if (vertices / 4 <= triangles.size()) {
    // The usual case: a table over all vertices is no larger than the triangles.
    std::vector<std::uint32_t> renumbered(vertices, kAbsent);
    for (const Corners& corners : triangles) {
      for (const std::uint32_t v : corners) renumbered[v] = 0;
    }
    for (std::uint32_t v = 0; v < vertices; ++v) {
      if (renumbered[v] == kAbsent) continue;
      renumbered[v] = static_cast<std::uint32_t>(used.size());
      used.push_back(v);
    }
    for (Corners& corners : triangles) {
      for (std::uint32_t& v : corners) v = renumbered[v];
    }
    return used;
  }
  for (const Corners& corners : triangles) used.insert(used.end(), corners.begin(), corners.end());
  std::ranges::sort(used);
  used.erase(std::unique(used.begin(), used.end()), used.end());
  for (Corners& corners : triangles) {
    for (std::uint32_t& v : corners) {
      v = static_cast<std::uint32_t>(std::ranges::lower_bound(used, v) - used.begin());
    }
  }
  return used;
}

Result<std::vector<Vec2f>> read_uv(const gltf::Document& document, const Json& attributes,
                                   const char* name, std::span<const std::uint32_t> vertices) {
  std::vector<Vec2f> uv;
  const std::uint32_t accessor = gltf::index_field(attributes, name);
  if (accessor == kAbsent) return uv;
  LB_ASSIGN_OR_RETURN(const gltf::Values values, gltf::read_elements(document, accessor, vertices));
  uv.resize(vertices.size());
  for (std::size_t i = 0; i < uv.size(); ++i) uv[i] = {values.data[2 * i], values.data[2 * i + 1]};
  return uv;
}

/// COLOR_0, three or four components; out of range is brought back into it.
Result<std::vector<scene::VertexColor>> read_colors(const gltf::Document& document,
                                                    const Json& attributes,
                                                    std::span<const std::uint32_t> vertices) {
  std::vector<scene::VertexColor> colors;
  const std::uint32_t accessor = gltf::index_field(attributes, "COLOR_0");
  if (accessor == kAbsent) return colors;
  LB_ASSIGN_OR_RETURN(const gltf::Values values, gltf::read_elements(document, accessor, vertices));
  const auto width = static_cast<std::size_t>(values.components);
  colors.resize(vertices.size());
  for (std::size_t i = 0; i < colors.size(); ++i) {
    const auto at = [&](std::size_t k) {
      return std::clamp(values.data[width * i + k], 0.0f, 1.0f);
    };
    colors[i].rgb = {at(0), at(1), at(2)};
    if (width > 3) colors[i].alpha = at(3);
  }
  return colors;
}

}  // namespace

std::string undrawable(const Json& primitive) {
  const std::uint64_t mode = gltf::unsigned_field(primitive, "mode", kTriangles);
  if (mode == 0) return "POINTS";
  if (mode < kTriangles) return "LINES";
  if (!primitive["attributes"].contains("POSITION")) return "no positions";
  return {};
}

std::uint64_t triangle_count(const gltf::Document& document, const Json& primitive) {
  const std::uint64_t corners = corner_count(document, primitive);
  const std::uint64_t mode = gltf::unsigned_field(primitive, "mode", kTriangles);
  if (mode == kTriangles) return corners / 3;
  return corners < 3 ? 0 : corners - 2;
}

Result<Primitive> read_primitive(const gltf::Document& document, const Json& primitive,
                                 PrimitiveNeeds needs) {
  Primitive result;
  const Json& attributes = primitive["attributes"];
  const std::uint32_t position = gltf::index_field(attributes, "POSITION");
  const std::uint64_t mode = gltf::unsigned_field(primitive, "mode", kTriangles);
  result.triangles.resize(triangle_count(document, primitive));
  for (std::uint32_t i = 0; i < result.triangles.size(); ++i) {
    result.triangles[i] = corners_of(mode, i);
  }
  const std::uint32_t index_accessor = gltf::index_field(primitive, "indices");
  if (index_accessor != kAbsent) {
    LB_ASSIGN_OR_RETURN(const std::vector<std::uint32_t> indices,
                        gltf::read_indices(document, index_accessor));
    for (Corners& corners : result.triangles) {
      for (std::uint32_t& v : corners) v = indices[v];
    }
  }
  const auto vertices = document.json["accessors"][position]["count"].get<std::uint32_t>();
  const std::vector<std::uint32_t> used = compact(result.triangles, vertices);

  LB_ASSIGN_OR_RETURN(const gltf::Values values, gltf::read_elements(document, position, used));
  result.positions.resize(used.size());
  for (std::size_t i = 0; i < used.size(); ++i) {
    const float* v = values.data.data() + 3 * i;
    result.positions[i] = {v[0], v[1], v[2]};
  }
  LB_ASSIGN_OR_RETURN(result.colors, read_colors(document, attributes, used));
  if (needs.uv0) {
    LB_ASSIGN_OR_RETURN(result.uv0, read_uv(document, attributes, "TEXCOORD_0", used));
  }
  if (needs.uv1) {
    LB_ASSIGN_OR_RETURN(result.uv1, read_uv(document, attributes, "TEXCOORD_1", used));
  }
  return result;
}

}  // namespace lightbatch::scene_in
