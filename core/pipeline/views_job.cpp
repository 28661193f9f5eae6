// What views of files submit to a renderer that culls by boxes: the same views for every file.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/base/parallel.h"
#include "core/batches/measure.h"
#include "core/pipeline/artifacts.h"
#include "core/pipeline/jobs.h"
#include "core/scene_in/read_scene.h"

namespace lightbatch::pipeline {
namespace {

using Json = nlohmann::json;

Json figures_json(const batches::ViewFigures& f, double ideal) {
  return {{"draws", f.draws},
          {"triangles", f.triangles},
          {"of_ideal", ideal > 0 ? f.triangles / ideal : 0.0},
          {"cost_us", f.cost}};
}

/// One file from the views of the first. The origin of its coordinates may lie elsewhere.
Result<Json> measure_file(const JobInput& input, const std::string& file,
                          const batches::ViewSet& views, const Vec3d& origin) {
  LB_ASSIGN_OR_RETURN(const gltf::Document document, gltf::read_document(input.files, file));
  LB_ASSIGN_OR_RETURN(const scene::Scene scene, scene_in::read_scene(document));
  std::vector<batches::DrawItem> draws = batches::draws_of_input(scene);
  const Vec3f shift = to_float(scene.origin - origin);
  for (batches::DrawItem& item : draws) {
    item.box.lower += shift;
    item.box.upper += shift;
  }
  const batches::ViewsFigures f = batches::measure_draws(views, draws);
  const auto drawn_besides = std::count_if(
      scene.skipped.begin(), scene.skipped.end(),
      [](const scene::Skipped& s) { return s.primitive != scene::kNone && s.reason != "hidden"; });
  // Further files lie in numbered folders: "1/scene.glb".
  const std::filesystem::path path = file;
  const auto name =
      file == input.scene ? path.filename() : path.parent_path().filename() / path.filename();
  return Json{{"file", name.string()},
              {"bytes", document.input_bytes},
              {"all_draws", draws.size()},
              {"all_triangles", scene.triangles.size()},
              {"passed_through", scene.skipped.size()},
              {"draws_not_counted", drawn_besides},
              {"inside", figures_json(f.inside, views.ideal_inside)},
              {"outside", figures_json(f.outside, views.ideal_outside)}};
}

std::string table_of(const Json& report) {
  char line[400];
  std::string text;
  std::snprintf(line, sizeof line, "%-36s %9s | %8s %11s %6s %9s | %8s %11s %6s %9s\n", "file",
                "draws", "inside:", "triangles", "/ideal", "cost us", "outside:", "triangles",
                "/ideal", "cost us");
  text += line;
  for (const Json& f : report["files"]) {
    const Json& in = f["inside"];
    const Json& out = f["outside"];
    std::snprintf(line, sizeof line,
                  "%-36.36s %9.0f | %8.1f %11.0f %6.2f %9.1f | %8.1f %11.0f %6.2f %9.1f\n",
                  f["file"].get<std::string>().c_str(), f.value("all_draws", 0.0),
                  in.value("draws", 0.0), in.value("triangles", 0.0), in.value("of_ideal", 0.0),
                  in.value("cost_us", 0.0), out.value("draws", 0.0), out.value("triangles", 0.0),
                  out.value("of_ideal", 0.0), out.value("cost_us", 0.0));
    text += line;
  }
  std::snprintf(line, sizeof line,
                "means of %.0f views from inside and %.0f from outside; profile %s; ideal: "
                "triangles not wholly outside the frustum\n",
                report["views"].value("inside", 0.0), report["views"].value("outside", 0.0),
                report.value("profile", "").c_str());
  text += line;
  for (const Json& f : report["files"]) {
    if (f.value("draws_not_counted", 0) == 0) continue;
    std::snprintf(line, sizeof line,
                  "%.200s: %d more draws are not counted (lines, points, what moves)\n",
                  f["file"].get<std::string>().c_str(), f.value("draws_not_counted", 0));
    text += line;
  }
  return text;
}

/// The hardware profile that the options name.
Result<batches::Profile> read_profile_option(const JobOptions& options, const JobInput& input) {
  const auto file = input.files.find(options.profile);
  if (file == input.files.end()) return batches::preset_profile(options.profile);
  LB_ASSIGN_OR_RETURN(const Bytes bytes, read_file(file->second));
  return batches::read_profile(as_text(bytes), options.profile);
}

}  // namespace

Result<batches::Viewpoints> read_viewpoints(const JobOptions& options, const JobInput& input,
                                            const scene::Scene& scene) {
  LB_ASSIGN_OR_RETURN(const batches::Profile profile, read_profile_option(options, input));
  std::vector<batches::View> cameras;
  if (!options.cameras_file.empty()) {
    const auto file = input.files.find(options.cameras_file);
    if (file == input.files.end()) {
      return bad_option("the cameras file " + options.cameras_file +
                        " is not among the job's files");
    }
    LB_ASSIGN_OR_RETURN(const Bytes bytes, read_file(file->second));
    LB_ASSIGN_OR_RETURN(cameras,
                        batches::read_cameras(as_text(bytes), options.cameras_file, scene.origin));
  }
  return batches::Viewpoints(scene, profile, std::move(cameras));
}

Result<JobOutcome> run_views(const JobOptions& options, const JobInput& input,
                             const std::filesystem::path& output, const Progress& progress) {
  Vec3d origin;
  batches::ViewSet views;
  {
    progress.report("read", 0);
    LB_ASSIGN_OR_RETURN(const gltf::Document document,
                        gltf::read_document(input.files, input.scene));
    LB_ASSIGN_OR_RETURN(const scene::Scene scene, scene_in::read_scene(document));
    origin = scene.origin;
    std::vector<Aabb> boxes(scene.triangles.size());
    for (std::uint32_t t = 0; t < boxes.size(); ++t)
      for (const Vec3f& p : scene.corners(t)) boxes[t].add(p);
    LB_ASSIGN_OR_RETURN(const batches::Viewpoints viewpoints,
                        read_viewpoints(options, input, scene));
    views = batches::make_view_set(scene, hierarchy::build(boxes), viewpoints);
  }
  Json report{
      {"schema", 1},
      {"kind", "views"},
      {"profile", views.profile.name},
      {"views", {{"inside", views.inside}, {"outside", views.outside}}},
      {"ideal_triangles", {{"inside", views.ideal_inside}, {"outside", views.ideal_outside}}},
      {"files", Json::array()}};
  std::vector<std::string> files{input.scene};
  files.insert(files.end(), options.other_scenes.begin(), options.other_scenes.end());
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (progress.cancelled()) return cancelled();
    progress.report("views", static_cast<double>(i) / static_cast<double>(files.size()));
    LB_ASSIGN_OR_RETURN(Json row, measure_file(input, files[i], views, origin));
    report["files"].push_back(std::move(row));
  }
  Artifacts artifacts(output);
  LB_RETURN_IF_ERROR(artifacts.add("views.json", report.dump(1) + "\n"));
  artifacts.keep();
  JobOutcome outcome;
  outcome.artifacts = artifacts.names();
  outcome.summary = table_of(report);
  return outcome;
}

}  // namespace lightbatch::pipeline
