// Batches of real files against the median k-d split of the same file (everything joined by
// material, cut at the median centroid of the longest axis): draws and triangles of a mean view
// from inside.
//
// batches_bench [--profile desktop] [--kd 1000,4000,16000] [--plain]
// [--growth 1.25] [--tenth] FILE.glb | office:TRIANGLES...
//
// --plain: only the chosen plan. --tenth: the best plan of a tenth of the input's draws as well.
// --growth: what copies of shared meshes may make of the bytes. For each k-d split, ours is the
// plan of the draw cost, found by bisection, that needs no more draws than it. Leaves that hold the
// whole scene are left out.

#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include "core/batches/measure.h"
#include "core/generate/office.h"
#include "core/scene_in/read_scene.h"
#include "core/scene_out/write_scene.h"

namespace lightbatch::bench {
namespace {

using batches::BatchOptions;
using batches::BatchPlan;
using batches::Profile;

struct Options {
  std::string profile = "desktop";
  std::vector<std::uint32_t> leaves = {1000, 4000, 16000};
  bool plain = false;
  double growth = 0;  // 0: the default
  bool tenth = false;
};

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// A scene with what plans of it start from.
struct Subject {
  std::string name;
  gltf::Document document;
  scene::Scene scene;
  hierarchy::Hierarchy tree;
  BatchOptions options;
};

bool open(const std::string& word, Subject& subject) {
  std::filesystem::path file = word;
  const bool office = word.starts_with("office:");
  if (office) {
    const auto bytes = generate::office_glb(std::stoull(word.substr(7)), 1);
    file = std::filesystem::temp_directory_path() / "batches_bench_office.glb";
    if (!bytes.ok() || !write_file(file, *bytes).ok()) return false;
  }
  auto document = gltf::read_document({{"scene.glb", file}}, "scene.glb");
  if (office) std::filesystem::remove(file);
  if (!document.ok()) {
    std::fprintf(stderr, "%s: %s\n", word.c_str(), document.status().to_string().c_str());
    return false;
  }
  subject.document = std::move(*document);
  auto scene = scene_in::read_scene(subject.document);
  if (!scene.ok()) return false;
  subject.scene = std::move(*scene);
  subject.name = office ? word : file.stem().string();
  std::vector<Aabb> boxes(subject.scene.triangles.size());
  for (std::uint32_t t = 0; t < boxes.size(); ++t)
    for (const Vec3f& p : subject.scene.corners(t)) boxes[t].add(p);
  subject.tree = hierarchy::build(boxes);
  subject.options.traits = scene_out::describe_objects(subject.document, subject.scene, nullptr);
  return true;
}

batches::ViewFigures inside(const Subject& s, const batches::ViewSet& views,
                            const BatchPlan& plan) {
  return batches::measure_draws(views, batches::draws_of_plan(s.scene, plan)).inside;
}

BatchPlan plan_of(const Subject& s, const Profile& profile, const BatchOptions& options) {
  return std::move(batches::plan(s.scene, s.tree, batches::Viewpoints(s.scene, profile), options))
      .value();
}

/// Where the price of a draw alone decides.
BatchPlan plan_at(const Subject& s, Profile profile, double draw) {
  profile.draw = draw;
  profile.state = 0;
  BatchOptions options = s.options;
  options.draws_share = 1;
  return plan_of(s, profile, options);
}

/// The plan of the finest cut that draws at most `draws` times in a mean view.
batches::ViewFigures at_most(const Subject& s, const batches::ViewSet& views, double draws) {
  double low = std::log(1e-2), high = std::log(1e5);  // us of a draw
  batches::ViewFigures best = inside(s, views, plan_at(s, views.profile, std::exp(high)));
  for (int step = 0; step < 12; ++step) {
    const double middle = 0.5 * (low + high);
    const auto figures = inside(s, views, plan_at(s, views.profile, std::exp(middle)));
    if (figures.draws <= draws) {
      high = middle;
      if (figures.triangles < best.triangles || best.draws > draws) best = figures;
    } else {
      low = middle;
    }
  }
  return best;
}

void run(const Subject& s, const Options& options) {
  const Profile profile = batches::preset_profile(options.profile).value();
  const double start = cpu_seconds();
  const BatchPlan plan = plan_of(s, profile, s.options);
  const double planned = cpu_seconds() - start;
  const batches::ViewSet views =
      batches::make_view_set(s.scene, s.tree, batches::Viewpoints(s.scene, profile));
  const auto before = batches::measure_draws(views, batches::draws_of_input(s.scene)).inside;
  const auto after = inside(s, views, plan);
  std::printf(
      "%-38s all %5llu -> %4llu  draws %7.1f -> %6.1f (/%.1f)  /ideal %5.2f -> %5.2f "
      "(x%.2f)  copied %+.0f %%  left %zu  cells %zu  %.2f s\n",
      s.name.c_str(), static_cast<unsigned long long>(plan.draws_before),
      static_cast<unsigned long long>(plan.draws_after), before.draws, after.draws,
      before.draws / after.draws, before.triangles / views.ideal_inside,
      after.triangles / views.ideal_inside, after.triangles / before.triangles,
      100 * plan.copied_bytes / plan.geometry_bytes, plan.left_alone.size(), plan.cells.size(),
      planned);
  if (options.tenth) {
    const auto ours = at_most(s, views, 0.1 * before.draws);
    std::printf("    a tenth: draws %7.1f  ours: %7.1f, %9.0f (%.2f)\n", 0.1 * before.draws,
                ours.draws, ours.triangles, ours.triangles / views.ideal_inside);
    std::fflush(stdout);
  }
  if (options.plain) return;
  for (const std::uint32_t leaf : options.leaves) {
    if (s.scene.triangles.size() <= leaf) continue;  // nothing is split
    const auto kd =
        batches::measure_draws(views, batches::draws_of_median_split(s.scene, leaf)).inside;
    const auto ours = at_most(s, views, kd.draws);
    std::printf(
        "    k-d %5u: draws %7.1f triangles %9.0f (%.2f)   ours: %7.1f, %9.0f (%.2f)  "
        "ratio %.2f %s\n",
        leaf, kd.draws, kd.triangles, kd.triangles / views.ideal_inside, ours.draws, ours.triangles,
        ours.triangles / views.ideal_inside, ours.triangles / kd.triangles,
        ours.draws <= kd.draws && ours.triangles < kd.triangles ? "" : "FAIL");
  }
  std::fflush(stdout);
}

}  // namespace
}  // namespace lightbatch::bench

int main(int argc, char** argv) {
  using namespace lightbatch::bench;
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--plain") {
      options.plain = true;
    } else if (word == "--tenth") {
      options.tenth = true;
    } else if (word == "--profile" && i + 1 < argc) {
      options.profile = argv[++i];
    } else if (word == "--growth" && i + 1 < argc) {
      options.growth = std::atof(argv[++i]);
    } else if (word == "--kd" && i + 1 < argc) {
      options.leaves.clear();
      for (char* leaf = std::strtok(argv[++i], ","); leaf != nullptr;
           leaf = std::strtok(nullptr, ","))
        options.leaves.push_back(static_cast<std::uint32_t>(std::atoi(leaf)));
    } else {
      Subject subject;
      if (!open(word, subject)) return 1;
      if (options.growth > 0) subject.options.max_growth = options.growth;
      run(subject, options);
    }
  }
  return 0;
}
