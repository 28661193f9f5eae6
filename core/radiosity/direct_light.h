#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/math/rgb.h"
#include "core/optics/optics.h"
#include "core/optics/surface_frame.h"
#include "core/radiosity/light_sources.h"
#include "core/rays/caster.h"

namespace lightbatch::radiosity {

/// What was cast and looked up, by effect. Plain sums: add them in any order.
struct RayCounts {
  std::uint64_t punctual_shadow = 0;
  std::uint64_t sun_shadow = 0;  // to suns of the sky
  std::uint64_t emitter_shadow = 0;
  std::uint64_t hemisphere = 0;   // gather and stored rays
  std::uint64_t sky_escapes = 0;  // hemisphere rays that reached the sky
  std::uint64_t alpha_lookups = 0;
  std::uint64_t sheet_crossings = 0;
  std::uint64_t polygon_factors = 0;

  /// Rays cast, of every kind.
  std::uint64_t cast() const { return punctual_shadow + sun_shadow + emitter_shadow + hemisphere; }

  RayCounts& operator+=(const RayCounts& o) {
    punctual_shadow += o.punctual_shadow;
    sun_shadow += o.sun_shadow;
    emitter_shadow += o.emitter_shadow;
    hemisphere += o.hemisphere;
    sky_escapes += o.sky_escapes;
    alpha_lookups += o.alpha_lookups;
    sheet_crossings += o.sheet_crossings;
    polygon_factors += o.polygon_factors;
    return *this;
  }
};

/// What VisibilitySum tells, by light group.
struct GroupVisibility {
  std::array<Rgbd, kMostGroups> visible, all;
};

/// The receiver of direct light: a point on one side of a triangle, or in free space.
struct Receiver {
  optics::SurfaceFrame frame;
  std::uint32_t triangle = rays::kNoTriangle;

  /// Open to every side: its normal is 0.
  static Receiver in_space(const Vec3f& point) {
    return {{point, {0, 0, 0}, point}, rays::kNoTriangle};
  }
  bool is_in_space() const { return frame.normal == Vec3f{0, 0, 0}; }
};

/// Light that comes to a point from one direction.
struct Incident {
  Vec3f direction;          // unit, to where it comes from
  Rgb light;                // luminance times solid angle: lux on a surface that faces it; 0: none
  std::uint32_t group = 0;  // of lights
};

/// Irradiance from emitters at one point, visibility apart: the exact point-to-polygon factor
/// (Lambert) for each emitter that matters, and for the rest a cut through the emitter tree with
/// one emitter picked by its bound under each node (Walter et al. 2005, with exact leaves).
struct EmitterTerms {
  static constexpr std::size_t kCapacity = 128;
  struct Term {
    std::uint32_t emitter = 0;
    std::uint32_t source = 0;  // the same for all terms of a lamp, or of a cut node above lamps
    Rgb irradiance;            // unoccluded, lux
    float weight = 0;          // channel sum of irradiance
    float scale = 1;           // 1 over the chance of a cut node's representative
    bool close = false;        // the emitter is one of `close`

    void scale_by(float factor) {
      irradiance *= factor;
      weight *= factor;
      scale *= factor;
    }
  };
  std::array<Term, kCapacity> term;
  std::size_t count = 0;  // of term
  /// Emitters nearer than asked for, of those that the cut has by themselves, whether they bring
  /// something or not.
  std::array<std::uint32_t, kCapacity> close;
  std::size_t close_count = 0;
  Rgb total;
  float weight = 0;
};

/// So many emitters need no cut.
constexpr std::size_t kFewEmitters = 8;

/// Running ratio of visible to all sampled emission, per channel.
struct VisibilitySum {
  Rgbd visible;
  Rgbd all;
  int rays = 0;
  void add(const VisibilitySum& o) {
    visible += o.visible;
    all += o.all;
    rays += o.rays;
  }
  /// Share of the unoccluded irradiance that arrives, per channel, in [0, 1].
  Rgb share() const {
    const auto ratio = [](double v, double a) { return a > 0 ? static_cast<float>(v / a) : 1.0f; };
    return {ratio(visible.r, all.r), ratio(visible.g, all.g), ratio(visible.b, all.b)};
  }
  bool none() const { return rays > 0 && visible.is_black(); }
  bool full() const { return rays > 0 && visible == all; }
};

/// Direct light from punctual lights and emitters. Immutable; thread-safe.
class DirectLight {
 public:
  /// shadows = false: nothing can stand between, so no shadow ray is cast.
  DirectLight(const optics::Optics& optics, const rays::Caster& caster, const LightSources& sources,
              bool shadows = true);

  const optics::Optics& optics() const { return *optics_; }
  const LightSources& sources() const { return *sources_; }
  float lift() const { return lift_; }

  /// What picks the representatives of cut nodes; irrelevant while all emitters are leaves.
  struct CutChoice {
    std::uint64_t seed = 0;
    /// In [0, 1): i / n for the i-th of n points that share a seed deals each node's emitters to
    /// them evenly, in the tree's order, which is one of place.
    float turn = 0;
    /// Nodes that are unsure by less than this share of the whole are not opened.
    float tolerance = 0.005f;
  };
  /// Nodes that are unsure by less than `negligible` lux (channel sum) are not opened.
  /// Emitters within `reach` metres are close. terms: scratch, large enough that callers keep it.
  void emitter_terms(const Receiver& at, const CutChoice& choice, EmitterTerms& terms,
                     RayCounts& counts, float negligible = 0, float reach = 0) const;

  /// The term of one emitter by itself; black where it brings nothing.
  EmitterTerms::Term emitter_term(const Receiver& at, std::uint32_t emitter,
                                  RayCounts& counts) const;

  /// What an emitter may bring to some point of a square of `edge` metres about the receiver: where
  /// it comes nearer than the square is large, all of its light, spread over the square, but no
  /// more than where it fills the hemisphere; 0 elsewhere. Lux, channel sum.
  float most_nearby(std::uint32_t emitter, const Receiver& at, float edge) const;

  /// Casts `rays` shadow rays to points of the emitters, chosen by what each term brings; sample
  /// indices first, first + 1... of the Owen-Sobol sequence of `seed`.
  VisibilitySum emitter_visibility(const Receiver& at, const EmitterTerms& terms, int rays,
                                   std::uint32_t first, std::uint32_t seed, RayCounts& counts,
                                   GroupVisibility* by_group = nullptr) const;

  /// One of these shadow rays, to a point of one term that is chosen with the given probability.
  void emitter_ray(const Receiver& at, const EmitterTerms::Term& term, double probability,
                   Vec2f random, RayCounts& counts, VisibilitySum& sum,
                   GroupVisibility* by_group = nullptr) const;

  /// Adds to each group its part of `arrives`, the light that reaches the receiver from `terms`:
  /// by what was seen of the group's own emitters, and in sum what arrives. scale: of all of it.
  void split_emitters(const EmitterTerms& terms, const Rgb& share, const GroupVisibility& seen,
                      float scale, std::span<Rgb> groups) const;

  /// What the emitters bring to the point, from one of them at random: unbiased, for points that
  /// are themselves one sample of many. At most one shadow ray, and often none where less than
  /// `worth` lux is to be had (Russian roulette). pick, random in [0, 1).
  struct Sampled {
    Rgb irradiance;
    std::uint32_t group = 0;  // of lights
  };
  Sampled sampled_emitters(const Receiver& at, float worth, double pick, Vec2f random,
                           RayCounts& counts) const {
    const Incident i = sampled_emitter(at, worth, pick, random, counts);
    return {i.light * dot(i.direction, at.frame.normal), i.group};
  }
  /// The same before the receiver's cosine; receivers in space take light from every side.
  Incident sampled_emitter(const Receiver& at, float worth, double pick, Vec2f random,
                           RayCounts& counts) const;

  /// What one punctual light brings to the point: one shadow ray. random: as below.
  Incident punctual(const Receiver& at, const PunctualLight& light, Vec2f random,
                    RayCounts& counts) const;

  /// Share of light i that reaches the point: one shadow ray (transmittance of sheets included).
  /// random, in [0, 1): where on a sun of the sky the ray goes to; its middle without.
  Rgb punctual_visibility(const Receiver& at, const PunctualLight& light, RayCounts& counts) const {
    return visibility_towards(at, light, light.towards(at.frame.origin), counts);
  }
  Rgb punctual_visibility(const Receiver& at, const PunctualLight& light, Vec2f random,
                          RayCounts& counts) const {
    return light.is_of_sky()
               ? visibility_towards(at, light, sources_->sun(light).direction(random), counts)
               : punctual_visibility(at, light, counts);
  }

  /// The opaque triangle that is the first thing between the receiver and the light (a sun's
  /// middle); rays::kNoTriangle: nothing is, or something that lets light through.
  std::uint32_t blocker(const Receiver& at, const PunctualLight& light, RayCounts& counts) const;

  /// Share of a point on another triangle that reaches the receiver: one ray, with shadows of
  /// lights or without.
  Rgb point_visibility(const Receiver& at, const Vec3f& point, std::uint32_t triangle,
                       RayCounts& counts) const;

 private:
  /// Share of a point of an emitter that reaches the receiver: one shadow ray.
  Rgb emitter_share(const Receiver& at, const Emitter& e, const Vec3f& point,
                    RayCounts& counts) const;
  Rgb visibility_towards(const Receiver& at, const PunctualLight& light, const Vec3f& towards,
                         RayCounts& counts) const;
  rays::Ray punctual_ray(const Receiver& at, const PunctualLight& light, const Vec3f& towards,
                         RayCounts& counts) const;
  Rgb open_irradiance(const Emitter& e, const Receiver& at, RayCounts& counts) const;
  rays::Ray shadow_ray(const Receiver& at, const Vec3f& point) const;
  Rgb through(const rays::Ray& ray, std::uint32_t a, std::uint32_t b, RayCounts& counts) const;

  const optics::Optics* optics_;
  const rays::Caster* caster_;
  const LightSources* sources_;
  float lift_ = 0;
  bool filtered_ = false;
  bool shadows_ = true;
};

}  // namespace lightbatch::radiosity
