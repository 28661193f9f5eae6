#pragma once

#include "core/batches/viewpoints.h"
#include "core/pipeline/job.h"

namespace lightbatch::pipeline {

/// One function for each kind of job; run_job is the door. Arguments as there, already validated.
Result<JobOutcome> run_bake(const JobOptions& options, const JobInput& input,
                            const std::filesystem::path& output, const Progress& progress);
/// plan.json, plan.html: effects with their evidence.
Result<JobOutcome> run_plan(const JobOptions& options, const JobInput& input,
                            const std::filesystem::path& output, const Progress& progress);
/// quote.json, quote.html: expected error against expected time.
Result<JobOutcome> run_quote(const JobOptions& options, const JobInput& input,
                             const std::filesystem::path& output, const Progress& progress);
/// sweep.csv, sweep.json, sweep.svg, sweep.html: certified error against time at several targets.
Result<JobOutcome> run_sweep(const JobOptions& options, const JobInput& input,
                             const std::filesystem::path& output, const Progress& progress);
/// hierarchy.json, boxes.glb (a node for each level), boxes_L.svg and boxes_L.png for each level L.
Result<JobOutcome> run_hierarchy(const JobOptions& options, const JobInput& input,
                                 const std::filesystem::path& output, const Progress& progress);

/// The artifacts of a bake for other lights: input.files are those of the bake.
Result<JobOutcome> run_relight(const JobOptions& options, const JobInput& input,
                               const std::filesystem::path& output, const Progress& progress);

/// views.json: draws and triangles of the scene and of other files, from the same views.
Result<JobOutcome> run_views(const JobOptions& options, const JobInput& input,
                             const std::filesystem::path& output, const Progress& progress);

/// Where the scene is looked at from: the hardware profile and the cameras that the options name.
/// The scene must outlive them.
Result<batches::Viewpoints> read_viewpoints(const JobOptions& options, const JobInput& input,
                                            const scene::Scene& scene);

}  // namespace lightbatch::pipeline
