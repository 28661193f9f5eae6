// The jobs about the price of accuracy: the quote before a bake, and the sweep that measures it.

#include <cstdio>

#include "core/pipeline/artifacts.h"
#include "core/pipeline/certify_stage.h"
#include "core/pipeline/jobs.h"
#include "core/pipeline/light_stage.h"
#include "core/pipeline/quote.h"
#include "core/pipeline/report_json.h"
#include "core/pipeline/tune.h"
#include "core/report/html.h"

namespace lightbatch::pipeline {
namespace {

Result<JobOutcome> finish(Artifacts& artifacts, const Progress& progress, std::string summary) {
  if (progress.cancelled()) return cancelled();
  artifacts.keep();
  JobOutcome outcome;
  outcome.artifacts = artifacts.names();
  outcome.summary = std::move(summary);
  return outcome;
}

/// What the figures below it are for.
std::string layout_line(const LightmapPlaces& places) {
  char line[96];
  std::snprintf(line, sizeof line, "%zu texels, %.4g per metre\n", places.texels.texels.size(),
                places.layout.texels_per_metre);
  return line;
}

}  // namespace

Result<JobOutcome> run_quote(const JobOptions& options, const JobInput& input,
                             const std::filesystem::path& output, const Progress& progress) {
  StageClock clock;
  LB_ASSIGN_OR_RETURN(const Prepared p, prepare(options, input, clock, progress));
  LB_ASSIGN_OR_RETURN(const LightmapPlaces places, make_places(options, p, clock, progress));
  LB_ASSIGN_OR_RETURN(const Quote quoted, quote(options, p, places, clock, progress));
  Json report = report_head(options, input, p);
  report["lightmaps"] = report_layout(places);
  report["quote"] = report_quote(quoted.prices);
  report_stages(report, clock);
  Artifacts artifacts(output);
  LB_RETURN_IF_ERROR(artifacts.add("quote.json", report.dump(1) + "\n"));
  LB_RETURN_IF_ERROR(artifacts.add("quote.html", report::html(report, {})));
  std::string summary = layout_line(places) + "error      expected   time\n";
  for (const Price& price : quoted.prices) {
    char line[128];
    char measured[32] = "-";
    if (price.error > 0) std::snprintf(measured, sizeof measured, "%.2f %%", 100 * price.error);
    std::snprintf(line, sizeof line, "%5.4g %%    %-9s  %.2f s\n", 100 * price.target, measured,
                  price.seconds);
    summary += line;
  }
  return finish(artifacts, progress, summary);
}

Result<JobOutcome> run_sweep(const JobOptions& options, const JobInput& input,
                             const std::filesystem::path& output, const Progress& progress) {
  StageClock clock;
  LB_ASSIGN_OR_RETURN(Prepared p, prepare(options, input, clock, progress));
  LB_ASSIGN_OR_RETURN(const LightmapPlaces places, make_places(options, p, clock, progress));
  std::vector<double> targets = options.sweep_errors;
  if (targets.empty()) targets.assign(std::begin(kQuotedErrors), std::end(kQuotedErrors));
  const double shared_seconds = clock.seconds();
  const double shared_cpu = clock.cpu_seconds();
  Json rows = Json::array();
  std::string summary =
      layout_line(places) + "target     certified (95 % interval)      seconds   CPU seconds\n";
  for (const double target : targets) {
    char phase[24];
    std::snprintf(phase, sizeof phase, "bake at %.3g%%", 100 * target);
    progress.report(phase, 0);
    clock.start(phase);
    StageClock own;
    p.target_error = target;
    own.start("pilot");
    LB_ASSIGN_OR_RETURN(const Tuned tuned, tune(options, p, places, target, progress));
    const auto settings =
        accuracy::settings_for(tuned.rungs, measure_for_settings(p, places), options.seed);
    LB_ASSIGN_OR_RETURN(const LightBake bake, bake_light(options, p, places, settings, own,
                                                         progress, {nullptr, false, tuned.first}));
    const double seconds = shared_seconds + own.seconds();
    const double cpu = shared_cpu + own.cpu_seconds();
    LB_ASSIGN_OR_RETURN(const accuracy::Certificate c,
                        certify(options, p, places, bake, own, progress));
    Json row = report_accuracy(c, target);
    row["seconds"] = seconds;
    row["cpu_seconds"] = cpu;
    row["peak_bytes"] = own.stages().back().peak_bytes;
    row["texels"] = places.texels.texels.size();
    rows.push_back(row);
    char line[160];
    std::snprintf(line, sizeof line, "%5.2g %%    %.3f %% (%.3f to %.3f %%)   %8.2f  %8.2f\n",
                  100 * target, 100 * c.relrmse, 100 * c.low, 100 * c.high, seconds, cpu);
    summary += line;
  }
  clock.stop();
  Json report = report_head(options, input, p);
  report["lightmaps"] = report_layout(places);
  report["sweep"] = rows;
  report_stages(report, clock);
  Artifacts artifacts(output);
  LB_RETURN_IF_ERROR(artifacts.add("sweep.json", report.dump(1) + "\n"));
  LB_RETURN_IF_ERROR(artifacts.add("sweep.csv", report::sweep_csv(report)));
  LB_RETURN_IF_ERROR(artifacts.add("sweep.svg", report::error_time_svg(report)));
  LB_RETURN_IF_ERROR(artifacts.add("sweep.html", report::html(report, {})));
  return finish(artifacts, progress, summary);
}

}  // namespace lightbatch::pipeline
