#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/lightmap/directional.h"
#include "core/pipeline/artifacts.h"
#include "core/pipeline/light_stage.h"

namespace lightbatch::pipeline {

/// Stage "directional": directional texels of the charts whose materials have normal maps.
Result<lightmap::DirectionalMap> bake_directional_lightmaps(
    const Prepared& p, const lightmap::BakeInput& input, const lightmap::GatherSettings& settings,
    StageClock& clock, const Progress& progress);

/// Writes lightmap_K_dir.exr for every page that holds such charts; returns what the scene's extras
/// say of them: [{page, file}].
Result<nlohmann::json> write_directional(const Prepared& p, const LightmapPlaces& places,
                                         const lightmap::DirectionalMap& map, Artifacts& artifacts);

}  // namespace lightbatch::pipeline
