#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/hierarchy/hierarchy.h"
#include "core/math/rgb.h"
#include "core/math/vec.h"
#include "core/optics/optics.h"
#include "core/scene/scene.h"

namespace lightbatch::accuracy {

/// The estimator's own lights: placed point and spot lights and emitting triangles, picked one at a
/// time with a known probability by a walk down a hierarchy over them (Estevez and Kulla 2018,
/// boxes and horizon only). Directional lights are kept apart: they reach everywhere alike.
/// Immutable; thread-safe.
class LightTree {
 public:
  struct Kinds {
    bool points = true;
    bool spots = true;
    bool suns = true;
    bool emitters = true;
  };
  LightTree(const scene::Scene& scene, const optics::Optics& optics, const Kinds& kinds);

  struct Pick {
    std::uint32_t light = 0;
    double probability = 0;  // 0: nothing can reach the point
  };
  /// Probability in proportion to about what each light brings to a point of this normal.
  Pick pick(const Vec3f& at, const Vec3f& normal, double random) const;
  /// The probability with which pick() gives this light.
  double probability(std::uint32_t light, const Vec3f& at, const Vec3f& normal) const;

  bool is_empty() const { return lights_.empty(); }
  bool is_triangle(std::uint32_t light) const { return lights_[light].triangle != kNoTriangle; }
  std::uint32_t triangle(std::uint32_t light) const { return lights_[light].triangle; }
  /// The light that is this triangle, or kNoLight.
  std::uint32_t light_of(std::uint32_t triangle) const {
    return light_of_triangle_.empty() ? kNoLight : light_of_triangle_[triangle];
  }
  /// Irradiance that a point or spot light brings to a point, nothing between
  /// (KHR_lights_punctual).
  Rgb punctual_irradiance(std::uint32_t light, const Vec3f& at, const Vec3f& normal) const;
  const Vec3f& position(std::uint32_t light) const { return lights_[light].position; }

  struct Sun {
    Vec3f towards;  // unit, to the light
    Rgb illuminance;
  };
  const std::vector<Sun>& suns() const { return suns_; }

  static constexpr std::uint32_t kNoLight = 0xffffffffu;
  static constexpr std::uint32_t kNoTriangle = 0xffffffffu;

 private:
  struct Light {
    std::uint32_t triangle = kNoTriangle;
    std::uint32_t leaf = 0;  // in leaf order of the tree
    Vec3f position;          // of a triangle: its centre
    Vec3f direction;         // of a triangle: its normal
    Rgb intensity;
    float strength = 0;  // intensity, or luminance times area, summed over channels
    float range = 0;
    float dip_inner = 0, dip_outer = 2;  // 1 - cosine
    bool spot = false;
    bool both_sides = false;
  };
  using Node = hierarchy::Hierarchy::NodeId;
  double importance(Node node, const Vec3f& at, const Vec3f& normal) const;

  std::vector<Light> lights_;
  std::vector<Sun> suns_;
  std::vector<std::uint32_t> light_of_triangle_;
  hierarchy::Hierarchy tree_;
  std::vector<float> strength_;  // per node
};

}  // namespace lightbatch::accuracy
