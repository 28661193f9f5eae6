#pragma once

#include <vector>

#include "core/accuracy/settings.h"
#include "core/pipeline/prepare.h"
#include "core/radiosity/direct_light.h"
#include "core/radiosity/element_lookup.h"
#include "core/radiosity/elements.h"
#include "core/radiosity/light_sources.h"
#include "core/radiosity/solution.h"
#include "core/radiosity/solver.h"

namespace lightbatch::pipeline {

/// The radiosity of every element, with all that it is made of; the parts refer to each other and
/// to what `Prepared` holds.
class FirstStage {
 public:
  FirstStage(const JobOptions& job, const Prepared& p, const accuracy::BakeSettings& settings);
  FirstStage(const FirstStage&) = delete;
  FirstStage& operator=(const FirstStage&) = delete;

  /// texels: of the lightmap whose light is to be kept apart by source, where there are several
  /// and the memory allows it; 0: none. CANCELLED.
  Status solve(const Prepared& p, SolverMode mode, std::size_t texels, const Progress& progress);

  /// Mean irradiance of one side of a triangle, lux, mean over channels. Cells of large triangles:
  /// a fixed spread of points stands for them.
  double irradiance_of(std::uint32_t triangle, bool back) const;

  accuracy::BakeSettings settings;
  radiosity::LightSources sources;
  radiosity::DirectLight direct;
  radiosity::Elements elements;
  radiosity::ElementLookup lookup;
  radiosity::SolverOptions options;
  radiosity::Solution solution;
  /// As in LightBake.
  std::vector<radiosity::LightGroup> groups;
  bool linked = false;
};

}  // namespace lightbatch::pipeline
