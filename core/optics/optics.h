#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/math/rgb.h"
#include "core/rays/caster.h"
#include "core/scene/scene.h"

namespace lightbatch::optics {

/// Reflectance is clamped here: closed scenes must converge.
constexpr float kMaxReflectance = 0.999f;

/// How the material of a triangle acts on light, point by point. Immutable; thread-safe.
///
/// With a = alpha coverage (MASK: 0 or 1; BLEND: alpha; OPAQUE: 1), t = transmission:
///   reflectance rho = a (1 - t) (1 - metallic) baseColor, at most 0.999
///   straight-through T = (1 - a) + a t (1 - metallic) baseColor (thin sheet, no refraction)
/// and with d = diffuse transmission, of color C: rho is (1 - d) of that, and
///   diffuse transmittance tau = a (1 - t) (1 - metallic) d C, rho + tau at most 0.999.
class Optics {
 public:
  /// Effects that a caller may switch off: what is off is not read at all.
  struct Options {
    bool alpha_cutout = true;
    bool alpha_blend = true;
    bool transmission = true;
    bool textured_reflectance = true;  // off: one value a triangle, at its centroid
    bool textured_emission = true;
    bool two_sided = true;
    bool diffuse_transmission = true;
  };
  explicit Optics(const scene::Scene& scene) : Optics(scene, Options{}) {}
  Optics(const scene::Scene& scene, const Options& options);

  /// What scatters at a point, and what that does to light.
  struct Scatterer {
    float coverage = 1;  // a (1 - t): share of a ray that meets it
    Rgb reflectance;     // rho and tau where coverage is 1
    Rgb diffuse_transmittance;
    Rgb transmittance;  // T: goes straight through
  };
  Scatterer scatterer(std::uint32_t triangle, float u, float v) const;

  /// Diffuse reflectance at barycentric (u, v) of the triangle.
  Rgb reflectance(std::uint32_t triangle, float u, float v) const;
  /// Emitted luminance of the front (of both sides when double-sided), nits: of the material, times
  /// the alpha coverage.
  Rgb emission(std::uint32_t triangle, float u, float v) const;
  /// Straight-through transmittance per channel.
  Rgb transmittance(std::uint32_t triangle, float u, float v) const;
  /// Share of the light that arrives on one side and leaves the other diffusely.
  Rgb diffuse_transmittance(std::uint32_t triangle, float u, float v) const;

  bool emits(std::uint32_t triangle) const { return flags_[triangle] & kEmits; }
  bool double_sided(std::uint32_t triangle) const { return flags_[triangle] & kDoubleSided; }
  /// Light passes through diffusely.
  bool transmits_diffusely(std::uint32_t triangle) const { return flags_[triangle] & kDiffuse; }
  bool any_diffuse_transmission() const { return diffuse_; }
  /// Both sides send light back: double-sided materials and those that transmit diffusely.
  bool has_two_sides(std::uint32_t triangle) const {
    return flags_[triangle] & (kDoubleSided | kDiffuse);
  }
  /// Reflectance varies over the triangle (texture), else one value serves.
  bool textured_reflectance(std::uint32_t triangle) const {
    return flags_[triangle] & kTexturedReflectance;
  }
  bool textured_emission(std::uint32_t triangle) const {
    return flags_[triangle] & kTexturedEmission;
  }
  /// Alpha leaves some of it away.
  bool covered_in_part(std::uint32_t triangle) const;
  /// About so many texels of the textures that decide what it emits lie on the triangle.
  double emission_texels(std::uint32_t triangle) const;
  /// Transmits partly somewhere (BLEND, transmission): a ray that hits it goes on, weakened.
  bool sheet(std::uint32_t triangle) const { return flags_[triangle] & kSheet; }

  /// kOpaque, kFiltered (alpha mixed, or sheet), kClear; one per triangle, for rays::Caster.
  const std::vector<rays::Surface>& surfaces() const { return surfaces_; }

  std::uint64_t opaque_count() const { return counts_[0]; }
  std::uint64_t filtered_count() const { return counts_[1]; }
  std::uint64_t clear_count() const { return counts_[2]; }

  const scene::Scene& scene() const { return *scene_; }

 private:
  enum Flag : std::uint8_t {
    kEmits = 1,
    kDoubleSided = 2,
    kTexturedReflectance = 4,
    kTexturedEmission = 8,
    kSheet = 16,
    kMask = 32,
    kVertexColor = 64,
    kDiffuse = 128,
  };
  struct Point;
  /// More than the material's constant factors decides.
  bool varying(const scene::Material& m, std::uint32_t triangle) const;
  static Point factors(const scene::Material& m);
  Point point(const scene::Material& m, std::uint32_t triangle, float u, float v) const;
  static Scatterer scattered_by(const Point& p, const Rgb& transmission_color);

  const scene::Scene* scene_;
  std::vector<std::uint8_t> flags_;
  std::vector<rays::Surface> surfaces_;
  std::uint64_t counts_[3] = {0, 0, 0};
  bool diffuse_ = false;
  std::vector<Scatterer> constant_;  // one per material; used when nothing varies
};

/// Lets rays pass cut-out texels. For closest hits: sheets stop the ray (the caller goes on behind
/// them). One filter serves one ray at a time.
class ClosestFilter final : public rays::HitFilter {
 public:
  explicit ClosestFilter(const Optics& optics) : optics_(optics) {}
  bool stops(const rays::Hit& hit) override;
  /// Alpha look-ups so far, for the effect counters.
  std::uint64_t asked() const { return asked_; }

 private:
  const Optics& optics_;
  std::uint64_t asked_ = 0;
};

/// For shadow rays: gathers the product of transmittances of everything that lets light through. A
/// sheet crossed exactly on the edge between two of its triangles counts once.
class ShadowFilter final : public rays::HitFilter {
 public:
  explicit ShadowFilter(const Optics& optics) : optics_(optics) {}
  bool stops(const rays::Hit& hit) override;
  Rgb transmittance() const { return transmittance_; }
  std::uint64_t asked() const { return asked_; }

 private:
  static constexpr std::size_t kRemembered = 8;
  struct EdgeCrossing {
    std::uint32_t object;
    float t;
  };

  const Optics& optics_;
  std::uint64_t asked_ = 0;
  Rgb transmittance_{1, 1, 1};
  EdgeCrossing edges_[kRemembered] = {};
  std::size_t edge_count_ = 0;
};

}  // namespace lightbatch::optics
