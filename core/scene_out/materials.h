#pragma once

#include <cstdint>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "core/gltf/document.h"

namespace lightbatch::scene_out {

/// Whether a texture of the material reads TEXCOORD_`set`.
bool uses_uv_set(const gltf::Json& root, std::uint32_t material, std::uint32_t set);

/// Whether the primitive's material, or that of a variant, has the thickness of
/// KHR_materials_volume, which is measured in the coordinates of the mesh.
bool is_thick(const gltf::Json& root, const gltf::Json& primitive);

/// (original, clone) of materials, by number.
using Clones = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// Puts the first clone of every original material that nothing uses any more into its place, so
/// that numbers and names lead to what is drawn. `original`: materials of the file as read.
/// Returns the clones by their new numbers.
Clones settle_materials(gltf::Json& root, std::uint32_t original, Clones clones);

/// Animations that change an original by KHR_animation_pointer change its clones, too.
void animate_clones(gltf::Json& root, const Clones& clones);

/// Whether the material's emissive factor is not black.
bool is_emissive(const gltf::Json& material);

/// By number of each emitting original, the list of its clones.
gltf::Json clones_of_emitters(const gltf::Json& root, const Clones& clones);

/// Clones of materials that carry baked light, made once each. A material index of kNone is the
/// default material.
class BakedMaterials {
 public:
  explicit BakedMaterials(gltf::Json& root);

  /// Textures of the lightmap pages, in page order.
  void set_pages(std::vector<std::uint32_t> textures, std::vector<float> intensity) {
    textures_ = std::move(textures);
    intensity_ = std::move(intensity);
  }

  /// The material with MOZ_lightmap of a page on texCoord 1. Where its textures used set 1, they
  /// read `moved_set` instead (kNone: none did).
  std::uint32_t with_lightmap(std::uint32_t material, std::uint32_t page, std::uint32_t moved_set);

  /// The material with a white base colour, for meshes whose COLOR_0 holds it. Stands for several
  /// materials, so it does not bear this one's name.
  std::uint32_t coloured(std::uint32_t material);

  /// The material as KHR_materials_unlit, to be multiplied by COLOR_0. `colour_in_vertices`: the
  /// vertex colours hold the whole colour, so the base colour factor becomes white.
  std::uint32_t unlit(std::uint32_t material, bool colour_in_vertices);

  /// (original, clone) of every clone with an original, in the order they were made.
  const Clones& clones() const { return clones_; }

 private:
  gltf::Json copy_of(std::uint32_t material) const;
  std::uint32_t add(std::uint32_t material, gltf::Json clone);

  gltf::Json& root_;
  std::uint32_t original_ = 0;  // materials of the file as read
  std::vector<std::uint32_t> textures_;
  std::vector<float> intensity_;
  std::map<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>, std::uint32_t> lightmapped_;
  std::map<std::pair<std::uint32_t, bool>, std::uint32_t> unlit_;
  std::map<std::uint32_t, std::uint32_t> coloured_;
  Clones clones_;
};

}  // namespace lightbatch::scene_out
