#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/status.h"
#include "core/gltf/document.h"

namespace lightbatch::pipeline {

enum class JobKind { kBake, kPlan, kQuote, kSweep, kHierarchy, kRelight, kViews };
enum class Compression { kAsInput, kNone, kMeshopt, kDraco };
enum class Quantization { kAsInput, kNone, kAll };
enum class Carrier { kLightmap, kPortable, kBoth };
enum class LightsPolicy { kRemove, kKeep };
enum class SolverMode { kAuto, kStoredRay, kLinked };

/// Everything a caller may ask for. Defaults are what a caller gets who asks for nothing.
/// validate() names contradictions.
struct JobOptions {
  JobKind kind = JobKind::kBake;
  double target_error = 0;      // relRMSE, 0.02 = 2 %; 0: not given (2 % unless a budget is given)
  double time_budget = 0;       // seconds; 0: not given
  double texels_per_metre = 0;  // 0: chosen from the scene
  int lightmap_size = 2048;     // largest page edge, 64..8192
  double sky_nits = 0;          // constant sky; 0: none
  std::string sky_file;         // key of JobInput::files: .hdr or .exr; empty: none
  Carrier carrier = Carrier::kLightmap;
  LightsPolicy lights = LightsPolicy::kRemove;
  SolverMode solver = SolverMode::kAuto;
  std::string profile = "desktop";  // desktop, webgl, mobile, or a key of JobInput::files (.json)
  std::string cameras_file;         // key of JobInput::files; empty: where people can stand
  int max_batches = 0;              // 0: the profile's cost decides
  std::uint32_t max_vertices = 0;   // of one primitive; 0: the profile's
  double max_growth = 16;           // of geometry, by copies of shared meshes
  double draws_share = 0.1;         // of the input's draws, for files of more than 500
  bool pvs = false;                 // write potentially visible sets
  bool keep_materials = false;      // none merged through vertex colours
  Compression compression = Compression::kAsInput;
  Quantization quantization = Quantization::kAsInput;
  bool batches = true;
  bool lightmaps = true;
  std::vector<std::string> effects;  // "+shadows", "-sky": overrides of the effect plan
  std::uint64_t seed = 1;
  int threads = 0;                        // 0: all
  std::vector<double> sweep_errors;       // kSweep
  std::vector<int> levels;                // kHierarchy: levels to draw; empty: 13,14,15,16,20
  bool compare = false;                   // kHierarchy: measure other builders too
  std::string lights_file;                // kRelight: key of JobInput::files
  std::vector<std::string> other_scenes;  // kViews: keys of JobInput::files
};
Status validate(const JobOptions& options);

struct JobInput {
  gltf::FileMap files;
  std::string scene;  // main file, a key of files
};

enum class Verdict {
  kDone,
  kMissedTarget,  // done, but the certified error is above the target
};

struct JobOutcome {
  Verdict verdict = Verdict::kDone;
  std::vector<std::string> artifacts;  // file names in the output folder, sorted
  std::string summary;                 // a few lines for people
};

/// Runs one job and writes its artifacts into `output` (an existing, empty folder). On an error
/// nothing is left there. One job at a time per process.
Result<JobOutcome> run_job(const JobOptions& options, const JobInput& input,
                           const std::filesystem::path& output, const Progress& progress);

/// Version and build of this program: part of every report and of every cache key.
std::string build_id();

}  // namespace lightbatch::pipeline
