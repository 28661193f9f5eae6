#pragma once

#include <span>
#include <vector>

#include "core/base/random.h"
#include "core/lightmap/bake.h"
#include "core/lightmap/guide.h"
#include "core/lightmap/near_links.h"
#include "core/lightmap/texel_points.h"
#include "core/lightmap/virtual_texel.h"

namespace lightbatch::lightmap {

/// Final gather: cosine rays from the points of a texel, reading the first stage where they land
/// and the sky where they do not.
///
/// Directions are Owen-scrambled Sobol points; a third dimension deals the rays to the texel's
/// points, so that every point sees the whole hemisphere, two more move them within their share. A
/// guide moves directions to where rays of texels around found light.
/// Light of the resolved lights is never read as an element's mean: lit elements use the light's
/// formula at the hit, mixed ones a shadow ray, and what lies far enough leaves it to the virtual
/// lights. Where a hit is near against the element's size, the texel there is linked, or, where
/// there is none, the element is replaced by one more gather.
class Gather {
 public:
  /// What texels take by other ways than by the light their own rays find.
  struct Aids {
    const NearTexels& near;
    const radiosity::VirtualLights& lights;
  };
  /// All outlive it. aids: null for readers of single directions.
  Gather(const BakeInput& input, const GatherSettings& settings, const Aids* aids = nullptr);

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
  /// The way of a ray so far, from the texel on.
  struct Path {
    Rgb weight{1, 1, 1};                     // of what is read, in the texel's sum
    std::span<Rgb> by_group;                 // gets what is read, by light group; empty: not asked
    std::vector<NearLink>* links = nullptr;  // get what texels near by bring; null: none
    const radiosity::VirtualLights::ReceiverPatch* receiver = nullptr;  // null: none

    bool grouped() const { return !by_group.empty(); }
    void add(std::size_t group, const Rgb& light) const { by_group[group] += weight * light; }
    Path times(const Rgb& factor) const { return {weight * factor, by_group, links, receiver}; }
    /// After a reflection.
    Path further(const Rgb& reflectance) const {
      return {weight * reflectance, by_group, links, nullptr};
    }
  };
  /// What comes down one ray from surfaces, as the first stage has them, and from the sky; what
  /// emitters send directly is not part of it.
  struct Along {
    Rgbd radiosity;               // pi times luminance, lm/m2
    double inverse_distance = 0;  // 1/metres, summed over the surfaces met
    bool meets_back = false;      // the first of them shows an absorbing back
  };
  Along along(const rays::Ray& ray, std::uint32_t exclude, const Numbers& numbers, const Path& path,
              BakeCounts& counts) const;

  struct Scratch {
    std::vector<NearLink> links;  // of the texel, after a gather
    radiosity::VirtualLights::Served served;
    /// Where the rays of the texels that follow go, and what they tell of it.
    Guide guide;
    GuideGrid learned;
  };
  /// seed must differ between texels; rays >= 1. by_group: gets the irradiance of each light group;
  /// empty: not asked.
  Value operator()(const TexelPoints& points, int rays, std::uint32_t seed, std::span<Rgb> by_group,
                   Scratch& scratch, BakeCounts& counts) const;

 private:
  /// Radiosity seen at a hit, lm/m2.
  Rgb seen(const rays::Hit& hit, float distance, const Numbers& numbers, int depth,
           const Path& path, BakeCounts& counts) const;
  /// served: the element whose virtual lights bring what the resolved lights bring to the hit;
  /// kNoElement where none do.
  Rgb read(radiosity::ElementId e, const rays::Hit& hit, radiosity::ElementId served,
           const Path& path, BakeCounts& counts) const;
  Rgb gather_deeper(radiosity::ElementId e, const rays::Hit& hit, radiosity::ElementId served,
                    const Numbers& numbers, int depth, const Path& path, BakeCounts& counts) const;
  /// `weight` times the irradiance from the hemisphere that the first stage found on an element,
  /// by groups as it has them.
  Rgb stand_for(radiosity::ElementId e, const Path& path, const Rgb& weight) const;
  /// Irradiance from lights but those that virtual lights stand for; a light that the element is
  /// dark to has none.
  Rgb direct(const radiosity::Receiver& at, radiosity::ElementId served, Random& random,
             const Path& path, BakeCounts& counts) const;
  radiosity::ElementId served(const rays::Hit& hit, const Path& path) const;

  const BakeInput& input_;
  const GatherSettings& settings_;
  const Aids* aids_;
  std::vector<std::uint8_t> resolved_;  // per punctual light: its place among the resolved ones
  std::vector<float> extent_;           // per element, metres
  std::vector<float> near_;  // per element, metres: nearer hits are gathered one level deeper
};

}  // namespace lightbatch::lightmap
