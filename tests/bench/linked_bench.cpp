// What the linked mode of the first stage (hierarchical radiosity with clusters) keeps of its
// promises, on one scene: row sums of closed rooms, links against triangles, and how the quality of
// the hierarchy shows in the links.
//
//   linked_bench SCENE.glb [--sky NITS] [--edge METRES] [--threshold SHARE]
//
// Thinned scenes keep their largest triangles and every k-th of the others, as a modeller would
// leave out detail. Errors are root mean squares over points of the surfaces, relative to the mean,
// against the same tree at a quarter of the threshold.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <map>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/hierarchy/comparators.h"
#include "core/optics/optics.h"
#include "core/pipeline/prepare.h"
#include "core/radiosity/linked_solver.h"
#include "tests/unit/accuracy/scene_kit.h"

namespace {

using namespace lightbatch;

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Settings {
  double edge = 0.2;
  double threshold = 1e-4;
  optics::Environment sky;
};

struct Meshes {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Aabb> boxes;
  std::vector<std::uint32_t> objects;

  explicit Meshes(const scene::Scene& scene) {
    for (std::uint32_t i = 0; i < scene.triangles.size(); ++i) {
      triangles.push_back(scene.triangles[i].vertex);
      objects.push_back(scene.triangles[i].object);
      Aabb box;
      for (const Vec3f& p : scene.corners(i)) box.add(p);
      boxes.push_back(box);
    }
  }
};

struct Solved {
  radiosity::Solution::Statistics statistics;
  double cpu = 0;
  double mean = 0, worst = 0;      // of the irradiance of elements, by area; largest off the mean
  std::vector<double> irradiance;  // at points of the surfaces, the same for every tree
};

/// Exits with the message of a failed solve: only a scene beyond all bounds does that.
Solved solve(const scene::Scene& scene, const hierarchy::Hierarchy& tree, const Settings& settings,
             double threshold) {
  const Meshes meshes(scene);
  const optics::Optics optics(scene);
  const rays::Caster caster(tree, scene.positions, meshes.triangles, optics.surfaces());
  const radiosity::LightSources sources(scene, optics, {});
  const radiosity::DirectLight direct(optics, caster, sources);
  radiosity::ElementOptions element_options;
  element_options.edge = settings.edge;
  const radiosity::Elements elements(scene, tree, optics, element_options);
  const radiosity::ElementLookup lookup(scene, caster, elements, direct.lift());
  radiosity::SolverOptions options;
  options.threshold = threshold;
  const double start = cpu_seconds();
  const auto solution = radiosity::solve_linked(
      {scene, tree, optics, caster, elements, direct, settings.sky, lookup}, options, Progress());
  if (!solution.ok()) {
    std::fprintf(stderr, "%s\n", solution.status().to_string().c_str());
    std::exit(1);
  }
  Solved solved;
  solved.cpu = cpu_seconds() - start;
  solved.statistics = solution->statistics;
  double area = 0;
  for (radiosity::ElementId e = 0; e < elements.count(); ++e) {
    const double a = static_cast<double>(elements.area(e));
    solved.mean += a * static_cast<double>(solution->irradiance[e].sum()) / 3;
    area += a;
  }
  solved.mean /= area;
  for (radiosity::ElementId e = 0; e < elements.count(); ++e) {
    const double value = static_cast<double>(solution->irradiance[e].sum()) / 3;
    solved.worst = std::max(solved.worst, std::abs(value / solved.mean - 1));
  }
  Random random(11);
  for (int i = 0; i < 4000; ++i) {
    const auto triangle = static_cast<std::uint32_t>(random.below(scene.triangles.size()));
    const Vec2f at = uniform_triangle({random.next_float(), random.next_float()});
    const radiosity::ElementId e = elements.at(triangle, at.x, at.y, false);
    solved.irradiance.push_back(
        e == radiosity::kNoElement ? 0.0 : static_cast<double>(solution->irradiance[e].sum()));
  }
  return solved;
}

double difference(const std::vector<double>& values, const std::vector<double>& reference) {
  double squares = 0, sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    squares += (values[i] - reference[i]) * (values[i] - reference[i]);
    sum += reference[i];
  }
  return std::sqrt(squares * static_cast<double>(values.size())) / sum;
}

void furnaces() {
  std::printf("Closed rooms in which every face emits: irradiance over pi / (1 - rho)\n\n");
  std::printf(
      "| room | rho | mean | largest off the mean | links |\n| --- | --- | --- | --- | --- |\n");
  for (const bool furnished : {false, true}) {
    for (const float rho : {0.5f, 0.9f, 0.99f, 0.999f}) {
      accuracy::SceneKit kit;
      const std::uint32_t all = kit.material(Rgb::grey(rho), {1, 1, 1});
      kit.box({0, 0, 0}, {4, 4, 4}, all);
      Random random(3);
      for (int i = 0; furnished && i < 27; ++i) {  // one in each cell of a grid: none overlap
        const Vec3f low{static_cast<float>(i % 3) * 1.3f + 0.1f + 0.4f * random.next_float(),
                        static_cast<float>(i / 3 % 3) * 1.3f + 0.1f + 0.4f * random.next_float(),
                        static_cast<float>(i / 9) * 1.3f + 0.1f + 0.4f * random.next_float()};
        const auto side = [&] { return 0.2f + 0.5f * random.next_float(); };
        kit.box(low, low + Vec3f{side(), side(), side()}, all, false);
      }
      kit.finish();
      Settings settings;
      settings.edge = 0.25;
      const Solved s = solve(kit.scene(), kit.tree(), settings, settings.threshold);
      const double exact = kPiDouble / (1 - static_cast<double>(rho));
      std::printf("| %s | %g | %.5f | %.2f %% | %llu |\n", furnished ? "27 boxes in it" : "empty",
                  static_cast<double>(rho), s.mean / exact, 100 * s.worst,
                  static_cast<unsigned long long>(s.statistics.links));
    }
  }
}

/// The `large` largest triangles and every k-th of the rest, about `count` in all.
scene::Scene thinned(const scene::Scene& whole, std::size_t large, std::size_t count) {
  std::vector<std::uint32_t> order(whole.triangles.size());
  std::iota(order.begin(), order.end(), 0u);
  std::vector<double> area(order.size());
  for (const std::uint32_t i : order) {
    const auto c = whole.corners(i);
    area[i] = length(cross(to_double(c[1] - c[0]), to_double(c[2] - c[0])));
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return area[a] > area[b]; });
  std::vector<bool> kept(order.size(), false);
  for (std::size_t i = 0; i < order.size(); ++i) {
    // As many of the rest as asked, evenly spread.
    const std::size_t rest = order.size() - large, wanted = count - large;
    kept[order[i]] = i < large || (i - large) * wanted / rest != (i - large + 1) * wanted / rest;
  }
  scene::Scene scene = whole;
  scene.triangles.clear();
  for (scene::Object& o : scene.objects) {
    const std::uint32_t first = o.first_triangle, end = first + o.triangle_count;
    o.first_triangle = static_cast<std::uint32_t>(scene.triangles.size());
    for (std::uint32_t t = first; t < end; ++t) {
      if (kept[t]) scene.triangles.push_back(whole.triangles[t]);
    }
    o.triangle_count = static_cast<std::uint32_t>(scene.triangles.size()) - o.first_triangle;
  }
  return scene;
}

void growth(const scene::Scene& scene, const Settings& settings) {
  std::printf("\nLinks against triangles (edge %g m, threshold %g)\n\n", settings.edge,
              settings.threshold);
  std::printf(
      "| triangles | elements | links | against the first | CPU s |\n| --- | --- | --- | --- | --- "
      "|\n");
  const std::size_t large = std::min<std::size_t>(1500, scene.triangles.size() / 2);
  double first = 0;
  for (const std::size_t count : {3'000u, 8'000u, 29'000u, 111'000u}) {
    if (count > scene.triangles.size()) break;
    const scene::Scene thin = thinned(scene, large, count);
    const Solved s =
        solve(thin, hierarchy::build(Meshes(thin).boxes), settings, settings.threshold);
    const double links = static_cast<double>(s.statistics.links);
    if (first == 0) first = links;
    std::printf("| %zu | %llu | %.0f | %+.0f %% | %.2f |\n", thin.triangles.size(),
                static_cast<unsigned long long>(s.statistics.elements), links,
                100 * (links / first - 1), s.cpu);
  }
}

void builders(const scene::Scene& scene, const Settings& settings) {
  std::printf("\nHierarchies at the same threshold\n\n");
  std::printf("| builder | links | error | CPU s |\n| --- | --- | --- | --- |\n");
  const Meshes meshes(scene);
  for (const hierarchy::Method method :
       {hierarchy::Method::kSweep, hierarchy::Method::kSweepReinsertion,
        hierarchy::Method::kMedianCut}) {
    const auto tree = hierarchy::build_with(method, meshes.boxes, meshes.objects);
    const Solved s = solve(scene, *tree, settings, settings.threshold);
    const Solved finer = solve(scene, *tree, settings, settings.threshold / 4);
    std::printf("| %s | %llu | %.2f %% | %.2f |\n", hierarchy::method_name(method).c_str(),
                static_cast<unsigned long long>(s.statistics.links),
                100 * difference(s.irradiance, finer.irradiance), s.cpu);
  }
}

Status run(const std::string& path, std::map<std::string, std::string>& option) {
  const auto number = [&](const char* name, double otherwise) {
    return option.contains(name) ? std::stod(option[name]) : otherwise;
  };
  pipeline::JobOptions options;
  options.target_error = 0.02;
  options.sky_nits = number("--sky", 0);
  pipeline::JobInput input;
  input.scene = "scene.glb";
  input.files[input.scene] = path;
  pipeline::StageClock clock;
  LB_ASSIGN_OR_RETURN(const pipeline::Prepared p,
                      pipeline::prepare(options, input, clock, Progress()));
  const Settings settings{number("--edge", 0.2), number("--threshold", 1e-4), p.sky};
  furnaces();
  growth(*p.scene, settings);
  builders(*p.scene, settings);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: linked_bench SCENE.glb [option value]...\n");
    return 2;
  }
  std::map<std::string, std::string> option;
  for (int i = 2; i + 1 < argc; i += 2) option[argv[i]] = argv[i + 1];
  const Status status = run(argv[1], option);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.to_string().c_str());
  return status.ok() ? 0 : 1;
}
