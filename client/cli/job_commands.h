#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "client/cli/session.h"

namespace lightbatch::cli {

/// What a command that runs a job was given, words as typed.
struct JobWords {
  std::string scene;
  std::string output;        // -o; empty: the command's default
  std::string target_error;  // "2%"
  std::string time_budget;   // "30s"
  double texels_per_metre = 0;
  int lightmap_size = 0;
  std::string sky;  // file or nits
  std::string carrier = "lightmap";
  std::string lights = "remove";
  std::string solver = "auto";
  std::string profile = "desktop";
  std::string cameras;  // file
  int max_batches = 0;
  bool pvs = false;
  bool no_batches = false;
  bool no_lightmaps = false;
  std::string effects;
  std::uint64_t seed = 1;
  int threads = 0;
  std::string errors;  // sweep
  std::string levels;  // hierarchy
  bool compare = false;
  std::uint32_t max_vertices = 0;
  double max_growth = 0;
  double draws_share = 0;
  bool keep_materials = false;
  std::string compress;
  std::string quantize;
  std::vector<std::string> others;  // views
  std::string lights_file;          // relight
  std::string report;               // copy of report.json
  bool json = false;
  bool quiet = false;
  bool no_cache = false;
};

/// Uploads the scene, submits the job, shows its progress, brings its files. Returns the exit code.
int run_job_command(v1::JobKind kind, const JobWords& words, const ServerOptions& server);

/// Follows a job to its end with a progress line; Ctrl-C cancels it. Ok: the ended job.
client::Outcome<v1::Job> follow(Session& session, const std::string& name, bool quiet);

/// Tells how a job ended that did not succeed; returns the exit code.
int report_ended(const v1::Job& job, bool json);

}  // namespace lightbatch::cli
