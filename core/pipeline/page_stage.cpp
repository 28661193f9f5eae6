#include "core/pipeline/page_stage.h"

#include <utility>

#include "core/image/codecs.h"
#include "core/lightmap/borders.h"

namespace lightbatch::pipeline {
namespace {

/// In each texel's stretch of border: where both sides are made to agree.
const std::vector<double> kAgreeAt{0.25, 0.75};
/// Of the target error, that making them agree may bring.
constexpr double kShareOfTarget = 0.3;

}  // namespace

Result<FinishedPages> finish_pages(const Prepared& p, const LightmapPlaces& places,
                                   LightBake& light, StageClock& clock) {
  clock.start("pages");
  FinishedPages finished;
  finished.pages = lightmap::make_pages(places.layout, places.texels, light.baked.irradiance);
  finished.stitches = lightmap::Stitches(
      places.layout,
      lightmap::find_borders(*p.scene, *p.caster, places.layout, places.texels, kAgreeAt),
      finished.pages, kShareOfTarget * p.target_error * mean_of_map(places, light));
  finished.stitches.apply(finished.pages);
  for (std::size_t i = 0; i < places.texels.texels.size(); ++i) {
    const atlas::Texel& t = places.texels.texels[i];
    light.baked.irradiance[i] = finished.pages[t.page].irradiance.at(t.x, t.y);
  }
  for (const lightmap::PageImage& page : finished.pages) {
    LB_ASSIGN_OR_RETURN(lightmap::EncodedPage encoded, lightmap::encode_page(page));
    finished.encoded.push_back(std::move(encoded));
  }
  clock.stop();
  return finished;
}

Status write_light_groups(const LightmapPlaces& places, const LightBake& light,
                          const FinishedPages& finished, const std::vector<GroupEntry>& groups,
                          Artifacts& artifacts) {
  const radiosity::GroupedLight& by_group = light.baked.by_group;
  if (by_group.is_empty()) return {};
  std::vector<std::vector<image::ExrLayer>> layers(finished.pages.size());
  std::vector<Rgb> part(light.baked.irradiance.size());
  for (std::size_t g = 0; g < groups.size(); ++g) {
    for (std::size_t t = 0; t < part.size(); ++t) part[t] = by_group.of(t)[g];
    auto pages = lightmap::make_pages(places.layout, places.texels, part);
    finished.stitches.apply(pages);
    for (std::size_t k = 0; k < pages.size(); ++k) {
      layers[k].push_back({groups[g].layer, std::move(pages[k].irradiance)});
    }
  }
  for (std::size_t k = 0; k < layers.size(); ++k) {
    LB_ASSIGN_OR_RETURN(const Bytes exr, image::encode_exr_layers(layers[k]));
    LB_RETURN_IF_ERROR(artifacts.add(light_groups_file(k), exr));
  }
  return {};
}

}  // namespace lightbatch::pipeline
