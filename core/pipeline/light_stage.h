#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/accuracy/settings.h"
#include "core/atlas/layout.h"
#include "core/atlas/texels.h"
#include "core/lightmap/bake.h"
#include "core/lightmap/directional.h"
#include "core/lightmap/pages.h"
#include "core/pipeline/prepare.h"
#include "core/probes/bake.h"
#include "core/radiosity/solution.h"

namespace lightbatch::pipeline {

/// The lightmap's places: what gets texels, and where.
struct LightmapPlaces {
  atlas::Layout layout;
  atlas::TexelMap texels;
};

/// Stages "charts" and "texels".
Result<LightmapPlaces> make_places(const JobOptions& options, const Prepared& p, StageClock& clock,
                                   const Progress& progress);

/// The radiosity of every element, and all that it is made of.
class FirstStage;

/// A baked lightmap with what the report tells of it.
struct LightBake {
  accuracy::BakeSettings settings;
  radiosity::Solution::Statistics radiosity;
  std::string mode;  // of the first stage
  double element_edge = 0;
  double mean_irradiance = 0;  // lux, of the first stage, over the surfaces with texels
  lightmap::BakedTexels baked;
  /// The sky last, black or not. baked.by_group has their light, unless all is of one source;
  /// empty: not kept apart.
  std::vector<radiosity::LightGroup> groups;
  std::shared_ptr<const FirstStage> first;                               // where it was asked for
  lightmap::DirectionalMap directional;                                  // empty: no normal maps
  double stage_seconds = 0, texel_seconds = 0, directional_seconds = 0;  // wall
  probes::LightProbes probes;  // empty: nothing moves, or a part of the texels only
};

/// What settings are chosen from.
accuracy::SceneMeasure measure_for_settings(const Prepared& p, const LightmapPlaces& places);

/// Mean irradiance of the lightmap's texels by their surface, lux, mean over channels.
double mean_of_map(const LightmapPlaces& places, const LightBake& light);

/// What of a lightmap is wanted, and what is there already.
struct LightWish {
  const std::vector<std::uint8_t>* selected = nullptr;  // these texels only (see select_texels)
  bool keep_first = false;                              // give the first stage back
  std::shared_ptr<const FirstStage> first;              // in place of one by the settings
};

/// Stages "radiosity", "gather" and, when they are on, "directional" and "probes". All texels: by
/// light group too, where there are several.
Result<LightBake> bake_light(const JobOptions& options, const Prepared& p,
                             const LightmapPlaces& places, const accuracy::BakeSettings& settings,
                             StageClock& clock, const Progress& progress,
                             const LightWish& wish = {});

}  // namespace lightbatch::pipeline
