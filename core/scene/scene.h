#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/image/image.h"
#include "core/math/aabb.h"
#include "core/math/mat.h"
#include "core/math/rgb.h"
#include "core/math/vec.h"

namespace lightbatch::scene {

constexpr std::uint32_t kNone = 0xffffffffu;

enum class Wrap : std::uint8_t { kRepeat, kClamp, kMirror };
enum class Filter : std::uint8_t { kLinear, kNearest };

/// A use of an image by a material: KHR_texture_transform already folded in.
/// uv' = (m00 u + m01 v + tu, m10 u + m11 v + tv), then wrap.
struct TextureSlot {
  std::uint32_t image =
      kNone;                // into Scene::images; kNone: no texture (or undecodable: factor only)
  std::uint8_t uv_set = 0;  // 0 or 1; larger sets count as absent
  Wrap wrap_u = Wrap::kRepeat;
  Wrap wrap_v = Wrap::kRepeat;
  Filter filter = Filter::kLinear;  // of magnification
  float m00 = 1, m01 = 0, m10 = 0, m11 = 1, tu = 0, tv = 0;
  bool present() const { return image != kNone; }
};

enum class AlphaMode : std::uint8_t { kOpaque, kMask, kBlend };

/// What light transport needs to know of a glTF material. Factors are linear Rec. 709.
struct Material {
  std::string name;
  std::uint32_t gltf_index = kNone;  // kNone: the default material
  Rgb base_color{1, 1, 1};
  float alpha = 1;
  TextureSlot base_color_texture;  // RGB: sRGB; alpha: linear
  float metallic = 1;
  TextureSlot metallic_texture;  // blue channel, linear
  Rgb emission{0, 0, 0};         // nits: emissiveFactor * KHR_materials_emissive_strength
  TextureSlot emission_texture;  // sRGB
  AlphaMode alpha_mode = AlphaMode::kOpaque;
  float alpha_cutoff = 0.5f;
  bool double_sided = false;
  bool unlit = false;
  bool has_normal_map = false;
  float transmission = 0;                    // KHR_materials_transmission, thin sheet
  TextureSlot transmission_texture;          // red channel
  float diffuse_transmission = 0;            // KHR_materials_diffuse_transmission
  TextureSlot diffuse_transmission_texture;  // alpha channel
  Rgb diffuse_transmission_color{1, 1, 1};
  TextureSlot diffuse_transmission_color_texture;  // sRGB

 private:
  template <typename Self>
  static auto slots_of(Self& m) {
    return std::array{&m.base_color_texture,
                      &m.metallic_texture,
                      &m.emission_texture,
                      &m.transmission_texture,
                      &m.diffuse_transmission_texture,
                      &m.diffuse_transmission_color_texture};
  }

 public:
  /// Every texture that light transport reads.
  auto texture_slots() { return slots_of(*this); }
  auto texture_slots() const { return slots_of(*this); }
};

enum class LightKind : std::uint8_t { kPoint, kSpot, kDirectional };

/// COLOR_0: linear factor of the base colour, and of alpha.
struct VertexColor {
  Rgb rgb{1, 1, 1};
  float alpha = 1;
  bool operator==(const VertexColor&) const = default;
};

/// KHR_lights_punctual, placed. Position in recentred coordinates (world minus Scene::origin).
struct Light {
  std::string name;
  std::uint32_t node = kNone;        // glTF node
  std::uint32_t gltf_index = kNone;  // into the extension's light array
  LightKind kind = LightKind::kPoint;
  Vec3d position;
  Vec3d direction{0, 0, -1};            // unit, the way the light shines
  Rgb intensity;                        // color * intensity: cd (point, spot) or lux (directional)
  double range = 0;                     // metres; 0: unlimited
  double cos_inner = 1, cos_outer = 0;  // spot cone
};

/// One primitive of one mesh under one node (and one GPU instance): the unit that batches keep
/// whole where that costs nothing.
struct Object {
  std::string name;  // node name, or mesh name, or "node 3"
  std::uint32_t node = kNone;
  std::uint32_t mesh = kNone;
  std::uint32_t primitive = 0;       // index within the mesh
  std::uint32_t instance = kNone;    // EXT_mesh_gpu_instancing index, or kNone
  std::uint32_t material = 0;        // into Scene::materials
  std::uint32_t first_triangle = 0;  // into Scene::triangles
  std::uint32_t triangle_count = 0;
  Affine to_world;        // object space to true world space (Scene::origin not subtracted)
  bool mirrored = false;  // negative determinant: winding was flipped so that front stays front
};

/// A triangle of the scene, front counter-clockwise (mirroring already undone).
struct Triangle {
  std::array<std::uint32_t, 3> vertex;  // into positions / uv0 / uv1
  std::uint32_t object = 0;
  std::uint32_t source = 0;  // index in the primitive's own triangle list (after strips and fans)
};

/// Why something was left out of light and batches, for the report.
struct Skipped {
  std::uint32_t node = kNone;
  std::uint32_t mesh = kNone;
  std::uint32_t primitive = kNone;
  std::string reason;  // "skinned", "morph targets", "animated", "hidden", "LINES", "POINTS", ...
};

/// A skinned, morphing or animated primitive. It is no part of the static scene: probes light it.
struct MovingMesh {
  std::string name;  // as Object::name
  std::uint32_t node = kNone;
  Aabbd rest;   // world box as the file stands, not animated
  Aabbd swept;  // world box of everywhere that the file's animations take it, rest included
};

/// Counts of what was mended or dropped while reading.
struct ReadCounts {
  std::uint64_t zero_area_triangles = 0;   // dropped: area 0, or collinear
  std::uint64_t zero_scale_nodes = 0;      // dropped with all they hold
  std::uint64_t textures_not_decoded = 0;  // factor used instead
  std::uint64_t clamped_reflectance = 0;   // materials whose factor exceeded 0.999
};

/// The default scene as light sees it: static, opaque-or-alpha triangles in one world space.
/// Positions are recentred in double before they become float: world = origin + position.
/// Immutable after reading. Every float in it is finite; every index is in range.
struct Scene {
  Vec3d origin;
  Aabb box;  // of positions
  std::vector<Vec3f> positions;
  std::vector<Vec2f> uv0;  // one per position, or empty when no material of the scene needs it
  std::vector<Vec2f> uv1;
  std::vector<VertexColor> colors;  // one per position, or empty when no primitive has COLOR_0
  std::vector<Triangle> triangles;  // grouped by object, in source order
  std::vector<Object> objects;
  std::vector<Material> materials;  // at least the default one when there are triangles
  std::vector<std::shared_ptr<const image::Image8>> images;
  std::vector<Light> lights;
  std::vector<Skipped> skipped;
  std::vector<MovingMesh> moving;
  ReadCounts counts;
  std::vector<std::string> warnings;

  const Material& material_of(std::uint32_t triangle) const {
    return materials[objects[triangles[triangle].object].material];
  }
  std::array<Vec3f, 3> corners(std::uint32_t triangle) const {
    const auto& v = triangles[triangle].vertex;
    return {positions[v[0]], positions[v[1]], positions[v[2]]};
  }
  /// Square metres, from the stored positions without further rounding.
  double area(std::uint32_t triangle) const {
    const auto c = corners(triangle);
    const Vec3d a = to_double(c[0]);
    return length(cross(to_double(c[1]) - a, to_double(c[2]) - a)) / 2;
  }
};

}  // namespace lightbatch::scene
