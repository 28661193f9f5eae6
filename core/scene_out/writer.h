#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "core/scene_out/json_access.h"
#include "core/scene_out/materials.h"
#include "core/scene_out/new_binary.h"
#include "core/scene_out/source_mesh.h"
#include "core/scene_out/write_scene.h"

namespace lightbatch::scene_out {

/// What the steps of one write share: the input, and the file as it grows.
class Writer {
 public:
  Writer(const gltf::Document& d, const scene::Scene& s, const atlas::Layout* l,
         const WriteOptions& o)
      : document(d),
        scene(s),
        layout(l),
        options(o),
        root(d.json),
        binary(root, static_cast<std::uint32_t>(d.buffers.size())),
        sources(d),
        materials(root) {}
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  bool portable() const { return options.carrier == Carrier::kPortable && options.irradiance; }
  /// Whether a triangle carries baked light in this file.
  bool has_light(std::uint32_t triangle) const {
    if (!portable()) return page_of(triangle) != kNone;
    return !scene.material_of(triangle).unlit &&
           (options.lit.empty() || options.lit[triangle] != 0);
  }
  /// Lightmap page of a triangle, kNone without one.
  std::uint32_t page_of(std::uint32_t triangle) const {
    if (layout == nullptr || layout->chart_of[triangle] == kNone) return kNone;
    return layout->charts[layout->chart_of[triangle]].page;
  }
  /// TEXCOORD_1 of the corners of a triangle that has a page.
  std::array<Vec2f, 3> uv1_of(std::uint32_t triangle) const {
    const atlas::Page& page = layout->pages[page_of(triangle)];
    std::array<Vec2f, 3> uv = layout->uv[triangle];
    for (Vec2f& p : uv)
      p = {p.x / static_cast<float>(page.width), p.y / static_cast<float>(page.height)};
    return uv;
  }
  /// The vertices of the source primitive at the corners of a triangle, in the scene's order.
  std::array<std::uint32_t, 3> source_vertices(const SourcePrimitive& source,
                                               std::uint32_t triangle) const {
    const scene::Triangle& t = scene.triangles[triangle];
    const std::uint32_t* c = source.corners.data() + 3 * std::size_t{t.source};
    if (scene.objects[t.object].mirrored) return {c[0], c[2], c[1]};
    return {c[0], c[1], c[2]};
  }
  std::uint32_t gltf_material(std::uint32_t scene_material) const {
    return scene.materials[scene_material].gltf_index;
  }

  /// A mesh with some primitives of an original one, which share its accessors; made once each.
  std::uint32_t part_of_mesh(std::uint32_t mesh, const std::vector<std::uint32_t>& primitives);

  const gltf::Document& document;
  const scene::Scene& scene;
  const atlas::Layout* layout;
  const WriteOptions& options;
  Json root;
  NewBinary binary;
  SourceMeshes sources;
  BakedMaterials materials;
  double exposure = 0;  // portable: luminance to colour
  WriteFacts facts;

 private:
  std::map<std::pair<std::uint32_t, std::vector<std::uint32_t>>, std::uint32_t> parts_;
};

/// First TEXCOORD set that a layout has free, 2 at least.
std::uint32_t free_uv_set(const std::vector<AttributeType>& types);

/// glTF wants sets without gaps: where there is no TEXCOORD_0, TEXCOORD_1 serves as both.
void fill_uv_sets(Json& attributes);

/// Appends a mesh's attributes and indices; returns the glTF primitive without a material.
Json add_primitive(NewBinary& binary, const std::vector<AttributeType>& types,
                   const std::vector<Bytes>& data, std::span<const std::uint32_t> indices);

}  // namespace lightbatch::scene_out
