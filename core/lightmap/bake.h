#pragma once

#include <vector>

#include "core/atlas/layout.h"
#include "core/atlas/texels.h"
#include "core/base/progress.h"
#include "core/base/status.h"
#include "core/optics/environment.h"
#include "core/radiosity/direct_light.h"
#include "core/radiosity/element_lookup.h"
#include "core/radiosity/elements.h"
#include "core/radiosity/solution.h"

namespace lightbatch::lightmap {

class DimShares;

/// How finely the texels are measured. Chosen from the asked error by the accuracy room.
struct GatherSettings {
  int rays = 128;           // hemisphere rays of a computed texel
  int block = 8;            // texels between the first computed texels of a chart; 1: all computed
  double tolerance = 0.03;  // of sharing: a block is split when its middle is off by this share
                            // of the mean irradiance
  double reach = 0.5;       // of sharing: block edge at most this many harmonic mean distances
  int pilot_rays = 4;       // emitter shadow rays of every texel
  double direct_error = 0.05;  // share of the mean irradiance that visibility may be off by in a
                               // texel of a shadow's edge; sets the number of shadow rays there
  double dim = 0;              // of errors allowed: exponent of a dim place's share (see dim.h)
  double deeper = 0.5;         // one more gather when a hit is nearer than this many element sizes
  double linked = 0.3;         // such hits are linked to the texel there unless they are nearer
                               // than this many of its sizes
  int virtual_lights = 2048;   // about so many where strong lights make small bright patches
  int virtual_rays = 16;       // rays of a computed texel to them
};

/// What the bake reads; all outlive it.
struct BakeInput {
  const scene::Scene& scene;
  const optics::Optics& optics;
  const rays::Caster& caster;
  const optics::Environment& sky;
  const radiosity::DirectLight& direct;
  const radiosity::Elements& elements;
  const radiosity::ElementLookup& lookup;
  const radiosity::Solution& solution;
  const atlas::Layout& layout;
  const atlas::TexelMap& texels;
  bool indirect = true;         // anything comes from the hemisphere (sky or interreflection)
  bool direct_lights = true;    // there are punctual lights or emitters
  bool punctual_direct = true;  // false: viewers add the direct light of punctual lights themselves
  double mean_irradiance = 0;   // lux, area mean of the first stage: the scale of tolerances
  std::size_t groups = 0;       // of lights, to keep apart: as in SolverInput
  std::uint64_t seed = 1;
  /// Texels to bake (one flag each, from select_texels), or null for all; the others are black, or
  /// rough where these need them.
  const std::vector<std::uint8_t>* selected = nullptr;

  /// Whether what a light brings without a bounce is part of the lightmap.
  bool bakes_direct(const radiosity::PunctualLight& light) const {
    return punctual_direct || light.is_of_sky();
  }
};

/// A fixed share, about one in `divisor`, of blocks of texels, whole ones of those that
/// bake_indirect starts from (of single texels where a chart has none): what a pilot bakes to learn
/// error and price.
std::vector<std::uint8_t> select_texels(const atlas::Layout& layout, const atlas::TexelMap& texels,
                                        int block, std::uint32_t divisor);

struct BakeCounts {
  radiosity::RayCounts rays;
  std::uint64_t texels = 0;
  std::uint64_t computed_texels = 0;  // gathered, the rest shared
  std::uint64_t border_rays = 0;      // for texels not selected, whose light those that are need
  std::uint64_t refined_texels = 0;   // direct light refined
  std::uint64_t deeper_gathers = 0;
  std::uint64_t near_links = 0;  // of these, left to the texel there

  BakeCounts& operator+=(const BakeCounts& o) {
    rays += o.rays;
    texels += o.texels;
    computed_texels += o.computed_texels;
    border_rays += o.border_rays;
    refined_texels += o.refined_texels;
    deeper_gathers += o.deeper_gathers;
    near_links += o.near_links;
    return *this;
  }
};

struct BakedTexels {
  std::vector<Rgb> irradiance;       // lux, per texel of the TexelMap, all light
  std::vector<Rgb> direct;           // lux, the part of punctual lights and emitters
  radiosity::GroupedLight by_group;  // lux, all light; empty: not asked
  BakeCounts counts;
  std::uint64_t direct_rays = 0;  // of counts.rays: shadow rays from texels
  /// Wall time of direct light and of gathering, without what is done once for all texels.
  double direct_seconds = 0, gather_seconds = 0;
};

/// Irradiance of every texel. The same bytes on any number of threads. CANCELLED.
Result<BakedTexels> bake_texels(const BakeInput& input, const GatherSettings& settings,
                                const Progress& progress);

/// Direct light alone: lux per texel; added to by_group, where it is not empty. seconds: gets
/// BakedTexels::direct_seconds; null: not asked.
std::vector<Rgb> bake_direct(const BakeInput& input, const GatherSettings& settings,
                             const DimShares& dim, radiosity::GroupedLight& by_group,
                             BakeCounts& counts, const Progress& progress,
                             double* seconds = nullptr);
/// Light from the hemisphere (interreflection and sky) alone; the same.
std::vector<Rgb> bake_indirect(const BakeInput& input, const GatherSettings& settings,
                               const DimShares& dim, radiosity::GroupedLight& by_group,
                               BakeCounts& counts, const Progress& progress,
                               double* seconds = nullptr);

}  // namespace lightbatch::lightmap
