#include "core/pipeline/directional_stage.h"

#include "core/image/codecs.h"
#include "core/lightmap/pages.h"

namespace lightbatch::pipeline {

Result<lightmap::DirectionalMap> bake_directional_lightmaps(
    const Prepared& p, const lightmap::BakeInput& input, const lightmap::GatherSettings& settings,
    StageClock& clock, const Progress& progress) {
  clock.start("directional");
  progress.report("directional", 0);
  auto map = lightmap::bake_directional(
      input, settings, lightmap::charts_with_normal_maps(*p.scene, input.layout), progress);
  clock.stop();
  return map;
}

Result<nlohmann::json> write_directional(const Prepared& p, const LightmapPlaces& places,
                                         const lightmap::DirectionalMap& map,
                                         Artifacts& artifacts) {
  const auto charts = lightmap::charts_with_normal_maps(*p.scene, places.layout);
  std::vector<std::uint8_t> asked(places.layout.pages.size());
  for (std::size_t c = 0; c < charts.size(); ++c) {
    if (charts[c] != 0) asked[places.layout.charts[c].page] = 1;
  }
  std::vector<Rgb> values(map.direction.size());
  for (std::size_t t = 0; t < values.size(); ++t) {
    values[t] = {map.direction[t].x, map.direction[t].y, map.direction[t].z};
  }
  std::vector<lightmap::PageImage> pages =
      lightmap::make_pages(places.layout, places.texels, values);
  for (const atlas::Texel& t : places.texels.texels) {
    lightmap::PageImage& page = pages[t.page];
    const auto at =
        static_cast<std::size_t>(t.y) * static_cast<std::size_t>(page.irradiance.width) + t.x;
    if (charts[t.chart] == 0) page.coverage[at] = 0;
  }
  nlohmann::json list = nlohmann::json::array();
  for (std::size_t k = 0; k < pages.size(); ++k) {
    if (asked[k] == 0) continue;
    const std::string name = "lightmap_" + std::to_string(k);
    LB_ASSIGN_OR_RETURN(const Bytes exr, lightmap::encode_exr(pages[k]));
    LB_RETURN_IF_ERROR(artifacts.add(name + "_dir.exr", exr));
    list.push_back({{"page", name}, {"file", name + "_dir.exr"}});
  }
  return list;
}

}  // namespace lightbatch::pipeline
