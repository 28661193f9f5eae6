#include "core/pipeline/probe_stage.h"

#include <algorithm>

namespace lightbatch::pipeline {

Result<probes::LightProbes> bake_light_probes(const Prepared& p, const lightmap::BakeInput& input,
                                              const lightmap::GatherSettings& settings,
                                              StageClock& clock, const Progress& progress) {
  clock.start("probes");
  progress.report("probes", 0);
  probes::ProbeSettings probe_settings;
  probe_settings.error = p.target_error;
  const lightmap::Gather gather(input, settings);
  auto baked = probes::bake_probes(input, gather, probes::place_probes(*p.scene, p.tree),
                                   probe_settings, progress);
  clock.stop();
  return baked;
}

nlohmann::json report_probes(const probes::LightProbes& probes) {
  const auto invalid = std::count(probes.valid.begin(), probes.valid.end(), 0);
  std::size_t cells = 0;
  double finest = 0;
  for (const probes::Volume& v : probes.grid.volumes) {
    cells += v.cells.size();
    finest = finest > 0 ? std::min(finest, v.step) : v.step;
  }
  return {{"probes", probes.grid.positions.size()}, {"invalid", invalid},
          {"volumes", probes.grid.volumes.size()},  {"cells", cells},
          {"finest_step_metres", finest},           {"noise", probes.noise},
          {"rays", probes.counts.rays.cast()}};
}

}  // namespace lightbatch::pipeline
