// The jobs that bake nothing: the effect plan, and the hierarchy with its drawings.

#include <algorithm>
#include <cstdio>

#include "core/hierarchy/level_boxes.h"
#include "core/image/codecs.h"
#include "core/pipeline/artifacts.h"
#include "core/pipeline/boxes_glb.h"
#include "core/pipeline/compare_stage.h"
#include "core/pipeline/jobs.h"
#include "core/pipeline/plan_cost.h"
#include "core/pipeline/prepare.h"
#include "core/pipeline/report_json.h"
#include "core/report/html.h"

namespace lightbatch::pipeline {
namespace {

constexpr int kPictureWidth = 1200;
constexpr int kPictureHeight = 900;
/// The levels of Figure 1 in Mueller, Schaefer, Fellner 1999.
constexpr int kFigureLevels[] = {13, 14, 15, 16, 20};

std::string plan_summary(const Json& report) {
  std::string text = "effect                 on     rays  why\n";
  for (const Json& e : report["plan"]["effects"]) {
    const bool on = e["on"].get<bool>();
    const double share = e.value("cost_share", 0.0);
    char cost[16] = "     -";
    if (on && share > 0) std::snprintf(cost, sizeof cost, "%4.0f %%", 100 * share);
    if (on && share > 0 && share < 0.01) std::snprintf(cost, sizeof cost, " < 1 %%");
    char line[160];
    std::snprintf(line, sizeof line, "%-22s %-4s %6s  ", e["name"].get<std::string>().c_str(),
                  on ? "on" : "off", cost);
    text += line + e["why"].get<std::string>() + "\n";
    for (const Json& evidence : e["evidence"]) text += "    " + evidence.get<std::string>() + "\n";
  }
  return text;
}

Result<JobOutcome> finish(Artifacts& artifacts, const Progress& progress, std::string summary) {
  if (progress.cancelled()) return cancelled();
  artifacts.keep();
  JobOutcome outcome;
  outcome.artifacts = artifacts.names();
  outcome.summary = std::move(summary);
  return outcome;
}

}  // namespace

Result<JobOutcome> run_plan(const JobOptions& options, const JobInput& input,
                            const std::filesystem::path& output, const Progress& progress) {
  StageClock clock;
  LB_ASSIGN_OR_RETURN(Prepared p, prepare(options, input, clock, progress));
  LB_RETURN_IF_ERROR(expect_costs(options, p, clock, progress));
  Json report = report_head(options, input, p);
  report_stages(report, clock);
  Artifacts artifacts(output);
  LB_RETURN_IF_ERROR(artifacts.add("plan.json", report.dump(1) + "\n"));
  LB_RETURN_IF_ERROR(artifacts.add("plan.html", report::html(report, {})));
  return finish(artifacts, progress, plan_summary(report));
}

Result<JobOutcome> run_hierarchy(const JobOptions& options, const JobInput& input,
                                 const std::filesystem::path& output, const Progress& progress) {
  StageClock clock;
  LB_ASSIGN_OR_RETURN(const Prepared p, prepare(options, input, clock, progress));
  Json report = report_head(options, input, p);
  Artifacts artifacts(output);
  clock.start("drawings");
  progress.report("drawings", 0);
  std::vector<int> levels = options.levels;
  if (levels.empty()) levels.assign(std::begin(kFigureLevels), std::end(kFigureLevels));
  std::sort(levels.begin(), levels.end());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  std::vector<BoxLevel> boxes;
  std::vector<report::Picture> pictures;
  for (const int level : levels) {
    if (progress.cancelled()) return cancelled();
    boxes.push_back({level, hierarchy::level_boxes(p.tree, level)});
    const std::string name = "boxes_" + std::to_string(level);
    const Bytes png = image::encode_png(
        hierarchy::level_picture(boxes.back().boxes, kPictureWidth, kPictureHeight), false);
    LB_RETURN_IF_ERROR(artifacts.add(name + ".png", png));
    LB_RETURN_IF_ERROR(artifacts.add(
        name + ".svg", hierarchy::level_svg(boxes.back().boxes, kPictureWidth, kPictureHeight)));
    pictures.push_back({"Level " + std::to_string(level), png, report::PictureKind::kHierarchy});
  }
  if (options.compare) {
    clock.start("compare");
    LB_ASSIGN_OR_RETURN(report["hierarchy"]["compare"], compare_builders(options, p, progress));
  }
  LB_ASSIGN_OR_RETURN(const Bytes glb, boxes_glb(boxes, p.scene->origin));
  LB_RETURN_IF_ERROR(artifacts.add("boxes.glb", glb));
  clock.stop();
  report_stages(report, clock);
  LB_RETURN_IF_ERROR(artifacts.add("hierarchy.json", report.dump(1) + "\n"));
  LB_RETURN_IF_ERROR(artifacts.add("hierarchy.html", report::html(report, pictures)));
  const auto& s = p.tree_statistics;
  char text[512];
  std::snprintf(
      text, sizeof text,
      "triangles   %u\nnodes       %u\ndepth       %d\nSAH cost    %.3f (leaves merged: %.3f)\n"
      "void area   %.3f\nbuild time  %.3f s\n",
      s.primitives, s.nodes, s.depth, s.sah_cost, s.sah_cost_merged, s.void_area, p.tree_seconds);
  std::string summary = text;
  if (options.compare) summary += comparison_text(report["hierarchy"]["compare"]);
  return finish(artifacts, progress, std::move(summary));
}

}  // namespace lightbatch::pipeline
