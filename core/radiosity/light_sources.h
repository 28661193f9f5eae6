#pragma once

#include <cstdint>
#include <vector>

#include "core/hierarchy/hierarchy.h"
#include "core/math/rgb.h"
#include "core/math/vec.h"
#include "core/optics/optics.h"
#include "core/optics/sky_suns.h"
#include "core/radiosity/light_groups.h"
#include "core/rays/caster.h"
#include "core/scene/scene.h"

namespace lightbatch::radiosity {

class EmissionParts;

/// A punctual light in recentred single precision, or a sun of the sky, ready for shading.
struct PunctualLight {
  static constexpr std::uint32_t kNoSun = 0xffffffffu;
  scene::LightKind kind = scene::LightKind::kPoint;
  Vec3f position;
  Vec3f direction;                     // the way it shines
  Rgb intensity;                       // cd or lux
  float range = 0;                     // 0: unlimited
  float dip_inner = 0, dip_outer = 1;  // 1 - cosine of a cone's angles: right for thin ones, too
  std::uint32_t group = 0;             // into LightSources::groups, or one past them: the sky's
  std::uint32_t sun = kNoSun;          // into LightSources::suns: directional, but not quite

  /// Irradiance at (position, unit normal) without anything between; lux.
  /// KHR_lights_punctual: 1/d2, range window max(min(1 - (d/range)^4, 1), 0), squared cone ramp.
  Rgb irradiance(const Vec3f& at, const Vec3f& normal) const;
  /// What range and cone leave of a point or spot light.
  float window(const Vec3f& at) const;
  /// Unnormalised direction to the light from a point (t = 1 is the light; infinite when
  /// directional).
  Vec3f towards(const Vec3f& at) const {
    return kind == scene::LightKind::kDirectional ? -direction : position - at;
  }
  bool is_directional() const { return kind == scene::LightKind::kDirectional; }
  bool is_of_sky() const { return sun != kNoSun; }
};

/// A triangle that emits, or the part of one where its texture is about even; or a point or spot
/// light of a scene that has many.
struct Emitter {
  static constexpr std::uint32_t kTriangle = 0xffffffffu;
  std::uint32_t triangle = rays::kNoTriangle;
  Vec3f a, b, c;    // counter-clockwise from the emitting side; of a point all three
  Rgb luminance;    // mean, nits
  float area = 0;   // m2
  float power = 0;  // pi * area * luminance of both sides, or pi * intensity, summed over channels
  bool double_sided = false;
  std::uint32_t group = 0;          // into LightSources::groups
  std::uint32_t point = kTriangle;  // into LightSources::points, or kTriangle
  std::uint32_t lamp = 0;           // the same for emitters that stand close together

  bool is_point() const { return point != kTriangle; }
  /// Of the triangle, or the point.
  Aabb box() const {
    Aabb box;
    for (const Vec3f& p : {a, b, c}) box.add(p);
    return box;
  }
};

/// Point and spot lights up to which each is a light of its own.
constexpr std::size_t kMostPunctual = 16;

/// Directions that a cluster of emitters faces: all within an angle of an axis.
struct FacingCone {
  Vec3f axis{0, 0, 1};   // unit
  float cos_angle = -1;  // -1: every direction
  static FacingCone of(const Emitter& e);
  /// Holds both (Conty Estevez and Kulla 2018, algorithm 1).
  static FacingCone around(const FacingCone& a, const FacingCone& b);
};

/// Everything in a scene that sends light out, the sky without its suns aside. Emitters have a
/// hierarchy of their own (the product's builder over their boxes) so that many of them cost less
/// than their number.
class LightSources {
 public:
  /// Which kinds take part; the effect plan decides.
  struct Kinds {
    bool point = true;
    bool spot = true;
    bool directional = true;
    bool emitters = true;
    /// Of more than kMostPunctual point and spot lights, all become emitters, so that many of them
    /// cost less than their number.
    bool points_as_emitters = true;
  };
  LightSources(const scene::Scene& scene, const optics::Optics& optics, const Kinds& kinds,
               std::vector<optics::SkySun> suns = {});

  const std::vector<PunctualLight>& punctual() const { return punctual_; }
  const std::vector<Emitter>& emitters() const { return emitters_; }
  /// The light that an emitter is, if it is no triangle.
  const PunctualLight& point(const Emitter& e) const { return points_[e.point]; }
  /// What a light is that is of the sky.
  const optics::SkySun& sun(const PunctualLight& light) const { return suns_[light.sun]; }
  /// The sky has none here.
  const std::vector<LightGroup>& groups() const { return groups_; }
  const hierarchy::Hierarchy& emitter_tree() const { return emitter_tree_; }
  /// Summed Emitter::power under a node of the emitter tree.
  float power(hierarchy::Hierarchy::NodeId node) const { return node_power_[node]; }
  /// Where the emitters under a node send light to.
  const FacingCone& facing(hierarchy::Hierarchy::NodeId node) const { return node_facing_[node]; }

 private:
  void add_punctual(const scene::Scene& scene, const Kinds& kinds, Grouping& grouping);
  void add_emitters(const scene::Scene& scene, const optics::Optics& optics, Grouping& grouping);
  void add_emitter(const scene::Scene& scene, const optics::Optics& optics, std::uint32_t triangle,
                   const EmissionParts& parts, Grouping& grouping);
  void add_points(const Kinds& kinds);
  void build_tree();
  void find_lamps();

  std::vector<optics::SkySun> suns_;
  std::vector<PunctualLight> punctual_;
  std::vector<PunctualLight> points_;
  std::vector<Emitter> emitters_;
  std::vector<LightGroup> groups_;
  hierarchy::Hierarchy emitter_tree_;
  std::vector<float> node_power_;
  std::vector<FacingCone> node_facing_;
};

}  // namespace lightbatch::radiosity
