#pragma once

#include <span>
#include <vector>

#include "core/lightmap/bake.h"
#include "core/lightmap/texel_points.h"

namespace lightbatch::lightmap {

/// Final gather: cosine rays from the points of a texel, reading the first stage where they land
/// and the sky where they do not.
///
/// Directions are Owen-scrambled Sobol points; a third dimension deals the rays to the texel's
/// points, so that every point sees the whole hemisphere, two more move them within their share.
/// Light of the resolved lights is never read as an element's mean: lit elements use the light's
/// formula at the hit, mixed ones a shadow ray. Where a hit is near against the element's size, the
/// element is replaced by one more gather.
class Gather {
 public:
  Gather(const BakeInput& input, const GatherSettings& settings);

  struct Value {
    Rgb irradiance;
    float variance = 0;  // of the mean of the channels, from the two halves of the rays
    float distance = 0;  // harmonic mean length of the rays, metres; infinite when all escape
  };
  /// Random numbers of one further gather; of the first, the direction is stratified with the ray.
  struct Numbers {
    std::uint64_t seed = 0;
    Vec2f direction;
  };
  /// Where what is read goes by light group: weight is that of what is read in the texel's sum.
  struct Split {
    std::span<Rgb> by_group;
    Rgb weight{1, 1, 1};
    bool asked() const { return !by_group.empty(); }
    void add(std::size_t group, const Rgb& light) const { by_group[group] += weight * light; }
    Split times(const Rgb& factor) const { return {by_group, weight * factor}; }
  };
  /// What comes down one ray from surfaces, as the first stage has them, and from the sky; what
  /// emitters send directly is not part of it.
  struct Along {
    Rgbd radiosity;               // pi times luminance, lm/m2
    double inverse_distance = 0;  // 1/metres, summed over the surfaces met
    bool meets_back = false;      // the first of them shows an absorbing back
  };
  Along along(const rays::Ray& ray, std::uint32_t exclude, const Numbers& numbers,
              const Split& split, BakeCounts& counts) const;

  /// seed must differ between texels; rays >= 1. by_group: gets the irradiance of each light group;
  /// empty: not asked.
  Value operator()(const TexelPoints& points, int rays, std::uint32_t seed, std::span<Rgb> by_group,
                   BakeCounts& counts) const;

 private:
  /// Radiosity seen at a hit, lm/m2.
  Rgb seen(const rays::Hit& hit, float distance, const Numbers& numbers, int depth,
           const Split& split, BakeCounts& counts) const;
  Rgb read(radiosity::ElementId e, const rays::Hit& hit, const Split& split,
           BakeCounts& counts) const;
  Rgb gather_deeper(radiosity::ElementId e, const rays::Hit& hit, const Numbers& numbers, int depth,
                    const Split& split, BakeCounts& counts) const;

  const BakeInput& input_;
  const GatherSettings& settings_;
  std::vector<float> near_;  // per element, metres: nearer hits are gathered one level deeper
};

}  // namespace lightbatch::lightmap
