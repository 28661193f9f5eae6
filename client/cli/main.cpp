// lightbatch: the command line. Exit codes are in exit_code.h.

#include <CLI/CLI.hpp>
#include <cstdlib>

#include "client/cli/exit_code.h"
#include "client/cli/job_commands.h"
#include "client/cli/output.h"
#include "client/cli/session.h"
#include "client/cli/store_commands.h"
#include "client/cli/word_checks.h"
#include "core/pipeline/job.h"
#include "server/worker.h"

namespace {

using namespace lightbatch;
using namespace lightbatch::cli;

constexpr const char* kDescription =
    "lightbatch prepares glTF scenes: lightmaps, render batches, a report.\n"
    "Without --server the service runs inside this program; with it, on a daemon.";
constexpr const char* kFooter =
    "Exit codes: 0 done, 2 bad usage, 3 the scene was refused, 4 done but the certified error\n"
    "missed the target, 5 the server could not be reached or refused, 6 cancelled, 70 internal.\n"
    "Results go to stdout, everything else to stderr.\n\n"
    "Examples:\n"
    "  lightbatch bake room.glb -o out --target-error 2%\n"
    "  lightbatch bake room.gltf -o out --sky 5000 --time-budget 2m --server build-host:7411\n"
    "  lightbatch scene office --triangles 100000 -o office.glb";

/// All words of the command line.
struct Words {
  ServerOptions server;
  JobWords job;
  std::string job_name;
  std::string folder;
  int most = 50;
  std::uint64_t triangles = 100'000;
  std::string office_file = "office.glb";
};

void add_common(CLI::App& command, Words& words) {
  command.add_option("--server", words.server.address, "Daemon to use, HOST:PORT")
      ->envname("LIGHTBATCH_SERVER")
      ->check(server_address);
  command.add_option("--data-dir", words.server.data,
                     "Without --server: keep jobs and cached results in this folder");
  command
      .add_option("--job-memory", words.server.job_memory_mib,
                  "Without --server: memory limit of the job, MiB (default: 3/4 of the machine)")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1} << 40));
  command.add_option("--tls-ca", words.server.tls_ca, "TLS: authority of the daemon, PEM file")
      ->check(CLI::ExistingFile);
  command.add_option("--tls-cert", words.server.tls_cert, "TLS: own certificate, PEM file")
      ->check(CLI::ExistingFile);
  command.add_option("--tls-key", words.server.tls_key, "TLS: own key, PEM file")
      ->check(CLI::ExistingFile);
  command.add_flag("--json", words.job.json, "Print the result as one JSON object");
  command.add_flag("-q,--quiet", words.job.quiet, "No progress");
}

void add_scene(CLI::App& command, Words& words) {
  command.add_option("SCENE", words.job.scene, "The scene: .gltf or .glb")->required();
  command.add_option("--seed", words.job.seed, "Seed of all random numbers")
      ->check(whole_number)
      ->capture_default_str();
  command.add_option("--threads", words.job.threads, "Threads; results do not depend on it")
      ->check(CLI::Range(1, 1024));
  command.add_option("--report", words.job.report, "Write report.json to this file too");
  command.add_flag("--no-cache", words.job.no_cache, "Compute anew even if the result is known");
  add_common(command, words);
}

/// Who looks at the scene, and with what.
void add_viewer(CLI::App& command, Words& words) {
  command
      .add_option("--profile", words.job.profile,
                  "Target hardware: desktop, webgl, mobile or a .json file")
      ->capture_default_str();
  command.add_option("--cameras", words.job.cameras,
                     "Views to choose batches for, instead of where people can stand (.json): "
                     "[{\"eye\": [0, 1.6, 0], \"target\": [0, 1.6, 1], \"weight\": 1}, ...]");
}

void add_light(CLI::App& command, Words& words) {
  command
      .add_option("--texels-per-metre", words.job.texels_per_metre,
                  "Lightmap density (default: chosen from the scene)")
      ->check(CLI::Range(1e-6, 1e6));
  command
      .add_option("--lightmap-size", words.job.lightmap_size,
                  "Largest page edge in texels (default: 2048)")
      ->check(CLI::Range(64, 8192));
  command.add_option("--sky", words.job.sky, "Sky: a picture (.hdr, .exr) or a radiance in cd/m2");
  command.add_option("--carrier", words.job.carrier, "How light travels: lightmap, portable, both")
      ->check(CLI::IsMember({"lightmap", "portable", "both"}))
      ->capture_default_str();
  add_viewer(command, words);
  command.add_option("--max-batches", words.job.max_batches, "Most batches (default: by cost)")
      ->check(CLI::Range(1, 1'000'000'000));
  command
      .add_option("--max-vertices", words.job.max_vertices,
                  "Most vertices of one primitive (default: the profile's)")
      ->check(CLI::Range(3u, 0xfffffffeu));
  command
      .add_option("--max-growth", words.job.max_growth,
                  "Geometry may grow by this factor through copies of instances (default: 16)")
      ->check(CLI::Range(1.0, 1e6));
  command
      .add_option("--draws-share", words.job.draws_share,
                  "Files of more than 500 draws: draws to keep, as a share (default: 0.1)")
      ->check(CLI::Range(1e-6, 1.0));
  command.add_flag("--keep-materials", words.job.keep_materials,
                   "Merge no materials through vertex colours");
  command
      .add_option(
          "--compress", words.job.compress,
          "Geometry of scene.glb: none, meshopt (exact), draco (smaller, rounded); default: "
          "as the input was")
      ->check(CLI::IsMember({"none", "meshopt", "draco"}));
  command
      .add_option("--quantize", words.job.quantize,
                  "16-bit integers in scene.glb: none, all (report.json says how far vertices "
                  "moved); default: as the input was")
      ->check(CLI::IsMember({"none", "all"}));
  command.add_flag("--pvs", words.job.pvs,
                   "Write pvs.json: which batches can be seen from which cells of walkable space");
  command.add_flag("--no-batches", words.job.no_batches, "Leave the scene's nodes as they are");
  command.add_flag("--no-lightmaps", words.job.no_lightmaps, "Bake no light");
  command.add_option("--effects", words.job.effects,
                     "Turn effects on and off: +x,-y (plan lists them)");
  command
      .add_option("--lights", words.job.lights,
                  "remove: bake the scene's lights; keep: bake indirect light only")
      ->check(CLI::IsMember({"remove", "keep"}))
      ->capture_default_str();
  command.add_option("--solver", words.job.solver, "auto, stored-ray or linked")
      ->check(CLI::IsMember({"auto", "stored-ray", "linked"}))
      ->capture_default_str();
}

CLI::App* add_job_command(CLI::App& app, Words& words, const char* name, const char* help,
                          bool light) {
  CLI::App* command = app.add_subcommand(name, help);
  command->add_option("-o,--output", words.job.output, "Folder for the results");
  add_scene(*command, words);
  if (light) add_light(*command, words);
  return command;
}

void add_accuracy(CLI::App& command, Words& words) {
  auto* error = command.add_option("--target-error", words.job.target_error,
                                   "Certified relative error to reach: 2% or 0.02 (default 2%)");
  command
      .add_option("--time-budget", words.job.time_budget,
                  "Best result in this time instead: 30s, 2m")
      ->excludes(error);
}

/// "--effects -x" would look like an option: the two words become one.
std::vector<std::string> join_effects(int argc, char** argv) {
  std::vector<std::string> words;
  for (int i = 1; i < argc; ++i) {
    std::string word = argv[i];
    if (word == "--effects" && i + 1 < argc) word += "=" + std::string(argv[++i]);
    words.push_back(std::move(word));
  }
  std::reverse(words.begin(), words.end());  // the order CLI11 wants
  return words;
}

int run(int argc, char** argv) {
  Words words;
  CLI::App app(kDescription, "lightbatch");
  app.set_version_flag("--version", pipeline::build_id());
  app.footer(kFooter);
  app.require_subcommand(1);

  auto* bake = add_job_command(app, words, "bake", "Bake lightmaps and batches", true);
  add_accuracy(*bake, words);
  auto* plan =
      add_job_command(app, words, "plan", "Effects on and off, with evidence and cost", true);
  auto* quote = add_job_command(app, words, "quote", "Expected error against expected time", true);
  auto* sweep =
      add_job_command(app, words, "sweep", "Bake at several errors; CSV, JSON, SVG", true);
  sweep->add_option("--errors", words.job.errors, "Errors to bake at: 10%,5%,2%,1%,0.5%");
  sweep->get_option("--output")->required();
  auto* hierarchy = add_job_command(app, words, "hierarchy",
                                    "Quality and boxes of the bounding-volume hierarchy", false);
  hierarchy->get_option("--output")->description("Folder, or one file: boxes.glb, .svg, .png");
  hierarchy->add_option("--levels", words.job.levels, "Levels to draw: 13,14,15,16,20");
  hierarchy->add_flag("--compare", words.job.compare, "Measure other builders too");
  auto* views = app.add_subcommand("views", "Draws and triangles that views submit, file by file");
  views->add_option("SCENE", words.job.others, "Files; the first gives the views")->required();
  add_viewer(*views, words);
  views->add_option("-o,--output", words.job.output, "Folder for views.json");
  views->add_option("--threads", words.job.threads, "Threads")->check(CLI::Range(1, 1024));
  views->add_option("--report", words.job.report, "Write views.json to this file too");
  add_common(*views, words);
  auto* relight = app.add_subcommand("relight", "New lights on an earlier bake");
  relight->add_option("BAKE", words.job.scene, "Folder of an earlier bake")->required();
  relight
      ->add_option("--lights", words.job.lights_file,
                   "New values (.json): {\"lights\": {NAME: {\"intensity\": 80, \"color\": "
                   "[1, 1, 1]}}, \"materials\": {NAME: {\"emissiveStrength\": 12, "
                   "\"emissiveFactor\": [1, 1, 1]}}, \"sky\": 500}")
      ->required();
  relight->add_option("-o,--output", words.job.output, "Folder for the results")->required();
  relight->add_option("--threads", words.job.threads, "Threads")->check(CLI::Range(1, 1024));
  relight->add_option("--report", words.job.report, "Write report.json to this file too");
  add_common(*relight, words);

  auto* jobs = app.add_subcommand("jobs", "List jobs, newest first");
  jobs->add_option("-n", words.most, "Most rows")
      ->check(CLI::Range(1, 1'000'000'000))
      ->capture_default_str();
  auto* watch = app.add_subcommand("watch", "Follow a job to its end");
  auto* cancel = app.add_subcommand("cancel", "Stop a job");
  auto* fetch = app.add_subcommand("fetch", "Bring the files of a job");
  fetch->add_option("-o,--output", words.folder, "Folder for the files")->required();
  for (CLI::App* command : {watch, cancel, fetch}) {
    command->add_option("JOB", words.job_name, "Job, as `jobs` lists it")->required();
  }
  for (CLI::App* command : {jobs, watch, cancel, fetch}) add_common(*command, words);

  auto* scene = app.add_subcommand("scene", "Made-up scenes for tests and trials");
  scene->require_subcommand(1);
  auto* office = scene->add_subcommand("office", "An office building of any size");
  office->add_option("--triangles", words.triangles, "About so many triangles")
      ->check(whole_number)
      ->capture_default_str();
  office->add_option("--seed", words.job.seed, "Another building")
      ->check(whole_number)
      ->capture_default_str();
  office->add_option("-o,--output", words.office_file, "File to write")->capture_default_str();

  refuse_empty_values(app);
  try {
    app.parse(join_effects(argc, argv));
  } catch (const CLI::RequiredError& error) {
    if (const auto unknown = unknown_command(app, argc, argv)) return usage_error(*unknown);
    app.exit(error);
    return kBadUsage;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kBadUsage;
  }
  const std::vector<std::pair<CLI::App*, v1::JobKind>> kinds = {
      {bake, v1::JOB_KIND_BAKE},           {plan, v1::JOB_KIND_PLAN},
      {quote, v1::JOB_KIND_QUOTE},         {sweep, v1::JOB_KIND_SWEEP},
      {hierarchy, v1::JOB_KIND_HIERARCHY}, {relight, v1::JOB_KIND_RELIGHT},
      {views, v1::JOB_KIND_VIEWS}};
  if (views->parsed()) {
    words.job.scene = words.job.others.front();
    words.job.others.erase(words.job.others.begin());
  }
  for (const auto& [command, kind] : kinds) {
    if (command->parsed()) return run_job_command(kind, words.job, words.server);
  }
  const bool json = words.job.json;
  if (jobs->parsed()) return list_jobs(words.server, words.most, json);
  if (watch->parsed()) return watch_job(words.server, words.job_name, json, words.job.quiet);
  if (cancel->parsed()) return cancel_job(words.server, words.job_name, json);
  if (fetch->parsed()) {
    return fetch_job(words.server, words.job_name, words.folder, json, words.job.quiet);
  }
  return make_office(words.triangles, words.job.seed, words.office_file);
}

}  // namespace

int main(int argc, char** argv) {
  const server::Engine engine = {pipeline::run_job, pipeline::validate, pipeline::build_id};
  if (const auto code = server::run_worker_if_asked(argc, argv, engine)) return *code;
  block_signals();
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "lightbatch: internal error: %s\n", error.what());
    return kInternal;
  }
}
