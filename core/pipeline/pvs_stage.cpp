#include "core/pipeline/pvs_stage.h"

#include "core/scene_out/names.h"
#include "core/scene_out/write_scene.h"

namespace lightbatch::pipeline {

Result<nlohmann::json> write_visible_sets(const JobOptions& options, const Prepared& p,
                                          const batches::Viewpoints& viewpoints,
                                          const batches::BatchPlan& plan, Artifacts& artifacts,
                                          StageClock& clock, const Progress& progress) {
  using Json = nlohmann::json;
  clock.start("pvs");
  progress.report("pvs", 0);
  batches::VisibleSetOptions settings;
  settings.seed = options.seed;
  settings.opens = scene_out::opening_objects(p.document, *p.scene);
  LB_ASSIGN_OR_RETURN(
      const batches::VisibleSets sets,
      batches::find_visible_sets(*p.scene, p.tree, viewpoints, plan, settings, progress));
  Json nodes = Json::array(), cells = Json::array();
  for (std::size_t i = 0; i < plan.batches.size(); ++i) nodes.push_back(scene_out::batch_name(i));
  for (std::size_t i = 0; i < plan.cells.size(); ++i) nodes.push_back(scene_out::cell_name(i));
  for (const batches::ViewCell& cell : sets.cells) {
    Json box = Json::array();
    for (const Vec3f& corner : {cell.box.lower, cell.box.upper})
      for (std::size_t axis = 0; axis < 3; ++axis)
        box.push_back(p.scene->origin[axis] + static_cast<double>(corner[axis]));
    cells.push_back({{"box", std::move(box)}, {"visible", cell.seen}});
  }
  Json summary{{"cells", sets.cells.size()},
               {"nodes", nodes.size()},
               {"mean_visible_share", sets.mean_share},
               {"rays", sets.rays},
               {"checked_rays", sets.checked},
               {"missed_rays", sets.missed}};
  const Json file{{"schema", 1},
                  {"kind", "pvs"},
                  {"nodes", std::move(nodes)},
                  {"cells", std::move(cells)},
                  {"checked_rays", sets.checked},
                  {"missed_rays", sets.missed}};
  LB_RETURN_IF_ERROR(artifacts.add("pvs.json", file.dump() + "\n"));
  clock.stop();
  return summary;
}

}  // namespace lightbatch::pipeline
