#include <algorithm>
#include <cstdio>

#include "core/accuracy/certificate.h"
#include "core/batches/measure.h"
#include "core/batches/plan.h"
#include "core/hierarchy/level_boxes.h"
#include "core/image/codecs.h"
#include "core/lightmap/look_up.h"
#include "core/pipeline/artifacts.h"
#include "core/pipeline/certify_stage.h"
#include "core/pipeline/directional_stage.h"
#include "core/pipeline/jobs.h"
#include "core/pipeline/light_groups_json.h"
#include "core/pipeline/page_stage.h"
#include "core/pipeline/plan_cost.h"
#include "core/pipeline/probe_stage.h"
#include "core/pipeline/pvs_stage.h"
#include "core/pipeline/quote.h"
#include "core/pipeline/report_json.h"
#include "core/pipeline/tune.h"
#include "core/pipeline/view_picture.h"
#include "core/report/html.h"
#include "core/scene_out/probes_file.h"
#include "core/scene_out/write_scene.h"

namespace lightbatch::pipeline {
namespace {

constexpr int kLevelPicture = 480;
constexpr int kViewWidth = 960;
constexpr int kViewHeight = 600;
/// Levels shown in the report of a bake.
constexpr int kReportLevels[] = {3, 6, 9, 13};

/// Of a time budget: no second pilot is started after it.
constexpr double kPilotShare = 0.15;
/// What a bake may take of its time budget before it says so.
constexpr double kBudgetSlack = 1.1;

/// All that a bake makes before it writes.
struct Made {
  LightmapPlaces places;
  LightBake light;
  FinishedPages finished;
  std::vector<GroupEntry> groups;
  batches::BatchPlan plan;
};

Status bake_pages(const JobOptions& options, Prepared& p, Made& made, Json& report,
                  StageClock& clock, const Progress& progress) {
  LB_ASSIGN_OR_RETURN(made.places, make_places(options, p, clock, progress));
  Tuned tuned;
  if (options.time_budget > 0) {
    LB_ASSIGN_OR_RETURN(const Quote quoted, quote(options, p, made.places, clock, progress,
                                                  kPilotShare * options.time_budget));
    p.target_error = error_for_time(quoted, options.time_budget - clock.seconds());
    report["quote"] = report_quote(quoted.prices);
    tuned = tuned_from(quoted, p.target_error);
  } else {
    clock.start("pilot");
    LB_ASSIGN_OR_RETURN(tuned, tune(options, p, made.places, p.target_error, progress));
  }
  report["expected"] = report_expected(tuned);
  const accuracy::BakeSettings settings =
      accuracy::settings_for(tuned.rungs, measure_for_settings(p, made.places), options.seed);
  LB_ASSIGN_OR_RETURN(made.light, bake_light(options, p, made.places, settings, clock, progress,
                                             {nullptr, false, std::move(tuned.first)}));
  LB_ASSIGN_OR_RETURN(made.finished, finish_pages(p, made.places, made.light, clock));
  return {};
}

Status plan_batches(const JobOptions& options, const Prepared& p,
                    const batches::Viewpoints& viewpoints, const batches::ViewSet& measured,
                    Made& made, const Progress& progress) {
  batches::BatchOptions batch_options;
  batch_options.max_batches = static_cast<std::uint32_t>(options.max_batches);
  batch_options.max_vertices = options.max_vertices;
  batch_options.max_growth = options.max_growth;
  batch_options.draws_share = options.draws_share;
  batch_options.traits = scene_out::describe_objects(
      p.document, *p.scene,
      options.lightmaps && options.carrier != Carrier::kPortable ? &made.places.layout : nullptr);
  if (options.keep_materials)
    for (batches::ObjectTraits& traits : batch_options.traits) traits.material_class = scene::kNone;
  if (options.lightmaps) {
    // Portable: lit and unlit triangles only have to stay apart.
    const bool pages = options.carrier != Carrier::kPortable;
    batch_options.page_of_triangle.resize(p.scene->triangles.size(), scene::kNone);
    for (std::size_t i = 0; i < batch_options.page_of_triangle.size(); ++i) {
      const std::uint32_t chart = made.places.layout.chart_of[i];
      if (chart != scene::kNone) {
        batch_options.page_of_triangle[i] = pages ? made.places.layout.charts[chart].page : 0;
      }
    }
  }
  LB_ASSIGN_OR_RETURN(
      made.plan, batches::plan(*p.scene, p.tree, viewpoints, batch_options, progress, &measured));
  return {};
}

/// A file that has both kinds stays lossless.
scene_out::Compression compression_of(const JobOptions& options, const gltf::Document& document) {
  using Written = scene_out::Compression;
  switch (options.compression) {
    case Compression::kNone:
      return Written::kPlain;
    case Compression::kMeshopt:
      return Written::kMeshopt;
    case Compression::kDraco:
      return Written::kDraco;
    case Compression::kAsInput:
      break;
  }
  if (document.had_meshopt) return Written::kMeshopt;
  return document.had_draco ? Written::kDraco : Written::kPlain;
}

scene_out::Quantization quantization_of(const JobOptions& options,
                                        scene_out::Compression compression) {
  using Written = scene_out::Quantization;
  if (compression == scene_out::Compression::kDraco) return Written::kOff;
  return options.quantization == Quantization::kAll    ? Written::kAll
         : options.quantization == Quantization::kNone ? Written::kOff
                                                       : Written::kAsInput;
}

Status write_scenes(const JobOptions& options, const Prepared& p, const Made& made, Json& report,
                    Artifacts& artifacts) {
  scene_out::LightmapImages images;
  for (const lightmap::EncodedPage& page : made.finished.encoded) {
    images.png.push_back(page.png);
    images.intensity.push_back(page.intensity);
  }
  scene_out::WriteOptions write;
  write.remove_lights = options.lightmaps && options.lights == LightsPolicy::kRemove;
  write.compression = compression_of(options, p.document);
  write.quantization = quantization_of(options, write.compression);
  if (options.quantization == Quantization::kAll &&
      write.quantization != scene_out::Quantization::kAll)
    report["warnings"].push_back("not quantized: the input's Draco compression rounds by itself");
  if (!made.light.probes.grid.positions.empty()) {
    write.extras["probes"] = {{"file", "probes.json"}};
    LB_RETURN_IF_ERROR(artifacts.add("probes.json", scene_out::probes_file(made.light.probes)));
  }
  if (!made.light.directional.direction.empty()) {
    LB_ASSIGN_OR_RETURN(write.extras["directional"],
                        write_directional(p, made.places, made.light.directional, artifacts));
  }
  const batches::BatchPlan* plan = options.batches ? &made.plan : nullptr;
  const atlas::Layout* layout = options.lightmaps ? &made.places.layout : nullptr;
  const auto tell = [&](const scene_out::WriteFacts& facts) {
    if (facts.quantized > 0)
      report["quantized"] = {{"primitives", facts.quantized},
                             {"position_error_metres", facts.position_error}};
    if (options.compression == Compression::kAsInput || options.compression == Compression::kNone ||
        facts.compressed)
      return;
    report["warnings"].push_back(
        "nothing is compressed: the scene has no geometry that this compression can hold (indexed "
        "triangles, without morph targets; for Draco without joints, too)");
  };
  scene_out::WriteFacts facts;
  if (options.carrier != Carrier::kPortable) {
    LB_ASSIGN_OR_RETURN(const Bytes glb, scene_out::write_scene(
                                             p.document, *p.scene, plan, layout,
                                             options.lightmaps ? &images : nullptr, write, &facts));
    tell(facts);
    LB_RETURN_IF_ERROR(artifacts.add("scene.glb", glb));
  }
  if (options.carrier == Carrier::kLightmap) return {};
  write.carrier = scene_out::Carrier::kPortable;
  write.lit.resize(p.scene->triangles.size());
  for (std::size_t i = 0; i < write.lit.size(); ++i) {
    write.lit[i] = made.places.layout.chart_of[i] != scene::kNone ? 1 : 0;
  }
  write.irradiance = [&](std::uint32_t triangle, float u, float v) {
    return lightmap::irradiance_at(made.places.layout, made.finished.pages, triangle, u, v);
  };
  write.emission = [&](std::uint32_t triangle, float u, float v) {
    return p.optics->emission(triangle, u, v);
  };
  LB_ASSIGN_OR_RETURN(const Bytes glb, scene_out::write_scene(p.document, *p.scene, plan, nullptr,
                                                              nullptr, write, &facts));
  tell(facts);
  return artifacts.add(options.carrier == Carrier::kPortable ? "scene.glb" : "scene_portable.glb",
                       glb);
}

std::vector<report::Picture> pictures(const JobOptions& options, const Prepared& p,
                                      const Made& made) {
  std::vector<report::Picture> list;
  if (p.scene->triangles.empty()) return list;
  if (options.lightmaps) {
    list.push_back({"View",
                    image::encode_png(view_picture(p, made.places.layout, made.finished.pages,
                                                   kViewWidth, kViewHeight),
                                      false),
                    report::PictureKind::kView, "Diffuse light only, as baked."});
    for (std::size_t i = 0; i < made.finished.pages.size(); ++i) {
      list.push_back({"lightmap_" + std::to_string(i),
                      image::encode_png(lightmap::preview(made.finished.pages[i]), false),
                      report::PictureKind::kLightmap});
    }
  }
  // A tenth of a second: dear beside batches alone, nothing beside light.
  if (!options.lightmaps) return list;
  for (const int level : kReportLevels) {
    if (level > p.tree_statistics.depth) break;
    list.push_back(
        {"Level " + std::to_string(level),
         image::encode_png(hierarchy::level_picture(hierarchy::level_boxes(p.tree, level),
                                                    kLevelPicture, kLevelPicture * 3 / 4),
                           false),
         report::PictureKind::kHierarchy});
  }
  return list;
}

/// Seconds of a time budget that the bake did not keep; 0 when it did.
double missed_budget(const Json& report) {
  const double budget = report["options"].value("time_budget_seconds", 0.0);
  return budget > 0 && report["total"].value("seconds", 0.0) > kBudgetSlack * budget ? budget : 0;
}

std::string summary_of(const Json& report) {
  char text[512];
  std::string summary;
  if (report.contains("lightmaps") && report["lightmaps"].value("texels", 0.0) == 0) {
    summary += "error    nothing to light: no surface takes a lightmap\n";
  } else if (report.contains("accuracy")) {
    const Json& a = report["accuracy"];
    std::snprintf(text, sizeof text,
                  "error    %.2f %% certified (95 %%: %.2f to %.2f %%), target %.2f %%\n",
                  100 * a.value("certified", 0.0), 100 * a.value("low", 0.0),
                  100 * a.value("high", 0.0), 100 * a.value("target", 0.0));
    summary += text;
  }
  if (report.contains("lightmaps")) {
    const Json& l = report["lightmaps"];
    std::snprintf(text, sizeof text, "texels   %.0f on %zu page(s), %.4g a metre\n",
                  l.value("texels", 0.0), l["pages"].size(),
                  l.value("texels_per_metre_given", 0.0));
    summary += text;
  }
  if (report.contains("batches")) {
    const Json& b = report["batches"];
    std::snprintf(text, sizeof text, "draws    %.0f before, %.0f after; in a view %.1f and %.1f\n",
                  b["before"].value("all_draws", 0.0), b["after"].value("all_draws", 0.0),
                  b["before"].value("draws", 0.0), b["after"].value("draws", 0.0));
    summary += text;
  }
  std::snprintf(text, sizeof text, "time     %.2f s, %.0f MB\n",
                report["total"].value("seconds", 0.0),
                report["total"].value("peak_bytes", 0.0) / 1e6);
  summary += text;
  if (const double budget = missed_budget(report); budget > 0) {
    std::snprintf(text, sizeof text, "budget   missed: %.4g s were asked\n", budget);
    summary += text;
  }
  return summary;
}

}  // namespace

Result<JobOutcome> run_bake(const JobOptions& options, const JobInput& input,
                            const std::filesystem::path& output, const Progress& progress) {
  StageClock clock;
  LB_ASSIGN_OR_RETURN(Prepared p, prepare(options, input, clock, progress));
  LB_ASSIGN_OR_RETURN(const batches::Viewpoints viewpoints,
                      read_viewpoints(options, input, *p.scene));
  Artifacts artifacts(output);
  Json report = report_head(options, input, p);
  Made made;
  JobOutcome outcome;
  if (options.lightmaps) {
    LB_RETURN_IF_ERROR(bake_pages(options, p, made, report, clock, progress));
    report["radiosity"] = report_radiosity(made.light);
    report["lightmaps"] =
        report_lightmaps(made.places, made.light.baked.counts, made.finished.encoded);
    made.groups = group_entries(options, p, made.light.groups);
    for (const GroupEntry& entry : made.groups) report["light_groups"].push_back(to_json(entry));
    if (p.effects.on(plan::Effect::kProbes)) report["probes"] = report_probes(made.light.probes);
    set_costs(p.effects, *p.scene, made.light);
    report_counters(report, p, made.light);
    LB_ASSIGN_OR_RETURN(const accuracy::Certificate certificate,
                        certify(options, p, made.places, made.light, clock, progress));
    report["accuracy"] = report_accuracy(certificate, p.target_error);
    LB_ASSIGN_OR_RETURN(
        const BorderChecks borders,
        check_borders(options, p, made.places, made.light, made.finished.pages, clock, progress));
    report["borders"] = report_borders(*p.scene, borders);
    if (!report["accuracy"].value("passed", true)) outcome.verdict = Verdict::kMissedTarget;
  }
  if (options.batches) {
    clock.start("batches");
    progress.report("batches", 0);
    const batches::ViewSet views = batches::make_view_set(*p.scene, p.tree, viewpoints);
    LB_RETURN_IF_ERROR(plan_batches(options, p, viewpoints, views, made, progress));
    report["batches"] = report_batches(p.document, *p.scene, made.plan,
                                       batches::measure_views(*p.scene, views, made.plan),
                                       viewpoints.profile().name);
    if (options.pvs) {
      LB_ASSIGN_OR_RETURN(report["pvs"], write_visible_sets(options, p, viewpoints, made.plan,
                                                            artifacts, clock, progress));
    }
  }
  if (!options.lightmaps) p.tree = hierarchy::Hierarchy();  // done with, and large
  clock.start("write");
  progress.report("write", 0);
  LB_RETURN_IF_ERROR(write_scenes(options, p, made, report, artifacts));
  for (std::size_t i = 0; i < made.finished.pages.size(); ++i) {
    LB_ASSIGN_OR_RETURN(const Bytes exr, lightmap::encode_exr(made.finished.pages[i]));
    LB_RETURN_IF_ERROR(artifacts.add("lightmap_" + std::to_string(i) + ".exr", exr));
  }
  LB_RETURN_IF_ERROR(
      write_light_groups(made.places, made.light, made.finished, made.groups, artifacts));
  const std::vector<report::Picture> shown = pictures(options, p, made);
  clock.stop();
  report_stages(report, clock);
  if (const double budget = missed_budget(report); budget > 0) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "the time budget of %.4g s was missed: the bake took %.4g s; `lightbatch quote` "
                  "tells what coarse bakes take",
                  budget, report["total"].value("seconds", 0.0));
    report["warnings"].push_back(text);
  }
  LB_RETURN_IF_ERROR(artifacts.add("report.json", report.dump(1) + "\n"));
  LB_RETURN_IF_ERROR(artifacts.add("report.html", report::html(report, shown)));
  if (progress.cancelled()) return cancelled();
  artifacts.keep();
  outcome.artifacts = artifacts.names();
  outcome.summary = summary_of(report);
  return outcome;
}

}  // namespace lightbatch::pipeline
