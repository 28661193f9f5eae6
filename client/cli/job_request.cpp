#include "client/cli/job_request.h"

#include <charconv>

#include "client/cli/units.h"
#include "lightbatch/client.h"

namespace lightbatch::cli {
namespace {

/// Manifest folder of the files that options name; scenes do not have one of this name.
constexpr const char* kInputFolder = "lightbatch.input/";

/// Collects what is wrong with the words; the first complaint counts.
class Builder {
 public:
  Builder(v1::JobKind kind, const JobWords& words) : words_(words) {
    request_.options.set_kind(kind);
  }

  std::variant<JobRequest, std::string> build() {
    accuracy();
    light();
    output();
    lists();
    if (!complaint_.empty()) return complaint_;
    return request_;
  }

 private:
  void complain(std::string text) {
    if (complaint_.empty()) complaint_ = std::move(text);
  }

  /// Puts a file beside the scene and returns its manifest path.
  std::string add_file(const std::string& file, const char* name, const char* option) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error)) {
      complain(std::string(option) + ": there is no file " + file);
    }
    const std::string path =
        kInputFolder + std::string(name) + std::filesystem::path(file).extension().string();
    request_.extra_files[path] = file;
    return path;
  }

  /// Puts a further scene and the files that it names beside the first.
  void add_scene(const std::string& file) {
    const auto files = client::scene_files(file);
    if (!files.ok()) return complain("there is no file " + file);
    const std::string folder =
        kInputFolder + std::to_string(request_.options.other_scenes_size() + 1) + "/";
    for (const auto& [path, beside] : *files) request_.extra_files[folder + path] = beside;
    request_.options.add_other_scenes(folder + client::manifest_name(file));
  }

  void accuracy() {
    if (!words_.target_error.empty() && !words_.time_budget.empty()) {
      complain("--target-error and --time-budget exclude each other");
    }
    if (!words_.target_error.empty()) {
      const auto bound = parse_error_bound(words_.target_error);
      if (!bound) complain("--target-error takes a bound like 2% or 0.02, above 0 and up to 100%");
      request_.options.set_target_error(bound.value_or(0));
    }
    if (!words_.time_budget.empty()) {
      const auto seconds = parse_duration(words_.time_budget);
      if (!seconds) complain("--time-budget takes a time like 30s, 2m or 1h");
      request_.options.set_time_budget_seconds(seconds.value_or(0));
    }
  }

  void light() {
    v1::JobOptions& options = request_.options;
    options.set_texels_per_metre(words_.texels_per_metre);
    options.set_lightmap_size(words_.lightmap_size);
    if (!words_.sky.empty()) {
      if (const auto nits = parse_number(words_.sky)) {
        if (*nits < 0) complain("--sky takes a radiance of at least 0 cd/m2");
        options.set_sky_nits(*nits);
      } else {
        options.set_sky_file(add_file(words_.sky, "sky", "--sky"));
      }
    }
    if (words_.lights == "keep") options.set_lights(v1::LIGHTS_POLICY_KEEP);
    if (words_.solver == "stored-ray") options.set_solver(v1::SOLVER_MODE_STORED_RAY);
    if (words_.solver == "linked") options.set_solver(v1::SOLVER_MODE_LINKED);
    if (!words_.lights_file.empty()) {
      options.set_lights_file(add_file(words_.lights_file, "lights", "--lights"));
    }
    options.set_seed(words_.seed);
    options.set_threads(words_.threads);
  }

  void output() {
    v1::JobOptions& options = request_.options;
    if (words_.carrier == "portable") options.set_carrier(v1::CARRIER_PORTABLE);
    if (words_.carrier == "both") options.set_carrier(v1::CARRIER_BOTH);
    const bool named =
        words_.profile == "desktop" || words_.profile == "webgl" || words_.profile == "mobile";
    options.set_profile(named ? words_.profile : add_file(words_.profile, "profile", "--profile"));
    if (!words_.cameras.empty())
      options.set_cameras_file(add_file(words_.cameras, "cameras", "--cameras"));
    options.set_max_batches(words_.max_batches);
    options.set_pvs(words_.pvs);
    options.set_skip_batches(words_.no_batches);
    options.set_skip_lightmaps(words_.no_lightmaps);
    options.set_compare(words_.compare);
    options.set_max_vertices(words_.max_vertices);
    options.set_max_growth(words_.max_growth);
    options.set_draws_share(words_.draws_share);
    options.set_keep_materials(words_.keep_materials);
    if (words_.compress == "none") options.set_compression(v1::COMPRESSION_NONE);
    if (words_.compress == "meshopt") options.set_compression(v1::COMPRESSION_MESHOPT);
    if (words_.compress == "draco") options.set_compression(v1::COMPRESSION_DRACO);
    if (words_.quantize == "none") options.set_quantization(v1::QUANTIZATION_NONE);
    if (words_.quantize == "all") options.set_quantization(v1::QUANTIZATION_ALL);
    for (const std::string& other : words_.others) add_scene(other);
  }

  void lists() {
    v1::JobOptions& options = request_.options;
    if (!words_.effects.empty()) {
      for (const std::string& effect : split_list(words_.effects)) {
        if (effect.size() < 2 || (effect[0] != '+' && effect[0] != '-')) {
          complain("--effects takes a list like +shadows,-sky");
        }
        options.add_effects(effect);
      }
    }
    if (!words_.errors.empty()) {
      for (const std::string& word : split_list(words_.errors)) {
        const auto bound = parse_error_bound(word);
        if (!bound) complain("--errors takes a list like 10%,5%,2%,1%");
        options.add_sweep_errors(bound.value_or(0));
      }
    }
    if (!words_.levels.empty()) {
      for (const std::string& word : split_list(words_.levels)) {
        int level = -1;
        const auto parsed = std::from_chars(word.data(), word.data() + word.size(), level);
        if (parsed.ec != std::errc() || parsed.ptr != word.data() + word.size() || level < 0) {
          complain("--levels takes a list like 13,14,15,16,20");
        }
        options.add_levels(level);
      }
    }
  }

  const JobWords& words_;
  JobRequest request_;
  std::string complaint_;
};

}  // namespace

std::variant<JobRequest, std::string> make_request(v1::JobKind kind, const JobWords& words) {
  return Builder(kind, words).build();
}

}  // namespace lightbatch::cli
