#pragma once

#include <vector>

#include "core/atlas/layout.h"
#include "core/image/image.h"
#include "core/lightmap/pages.h"
#include "core/pipeline/prepare.h"

namespace lightbatch::pipeline {

/// The baked scene as a viewer would show it: diffuse surfaces, reflectance times irradiance / pi
/// from the lightmap, emission, sky; one exposure for the picture. The camera is the scene's first
/// perspective camera, or one that is looked for: inside a room from where a person's eyes can be,
/// outside from above. Same input, same picture.
image::Image8 view_picture(const Prepared& p, const atlas::Layout& layout,
                           const std::vector<lightmap::PageImage>& pages, int width, int height);

}  // namespace lightbatch::pipeline
