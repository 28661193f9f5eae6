#pragma once

#include <vector>

#include "core/lightmap/pages.h"
#include "core/lightmap/stitch.h"
#include "core/pipeline/artifacts.h"
#include "core/pipeline/light_groups_json.h"
#include "core/pipeline/light_stage.h"

namespace lightbatch::pipeline {

/// The lightmap as viewers get it.
struct FinishedPages {
  std::vector<lightmap::PageImage> pages;
  std::vector<lightmap::EncodedPage> encoded;
  lightmap::Stitches stitches;  // already in the pages
};

/// Stage "pages": gutters filled, borders of charts that meet on one surface made to agree. The
/// texels in `light` become those of the pages.
Result<FinishedPages> finish_pages(const Prepared& p, const LightmapPlaces& places,
                                   LightBake& light, StageClock& clock);

/// light_groups_K.exr: the part of each light group in page K, lux. Where all light is of one
/// source there are none.
Status write_light_groups(const LightmapPlaces& places, const LightBake& light,
                          const FinishedPages& finished, const std::vector<GroupEntry>& groups,
                          Artifacts& artifacts);

}  // namespace lightbatch::pipeline
