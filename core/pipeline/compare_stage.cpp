#include "core/pipeline/compare_stage.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "core/base/random.h"
#include "core/hierarchy/comparators.h"
#include "core/radiosity/direct_light.h"
#include "core/radiosity/elements.h"
#include "core/radiosity/light_sources.h"
#include "core/radiosity/linked_solver.h"
#include "core/rays/compare.h"

namespace lightbatch::pipeline {
namespace {

/// Coarse elements: the trees are compared, not the picture.
constexpr std::uint64_t kElements = 20'000;
constexpr double kThreshold = 4e-4;
constexpr double kFinerThreshold = kThreshold / 4;
constexpr std::uint32_t kSamples = 4000;

struct Meshes {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> objects;
  std::vector<Aabb> boxes;
};

Meshes meshes_of(const scene::Scene& scene) {
  Meshes m;
  m.boxes.resize(scene.triangles.size());
  for (std::uint32_t i = 0; i < scene.triangles.size(); ++i) {
    m.triangles.push_back(scene.triangles[i].vertex);
    m.objects.push_back(scene.triangles[i].object);
    for (const Vec3f& p : scene.corners(i)) m.boxes[i].add(p);
  }
  return m;
}

struct Solved {
  radiosity::Solution::Statistics statistics;
  double seconds = 0;
  std::vector<double> irradiance;  // at points of the surfaces, the same for every tree
};

class LinkedSolves {
 public:
  LinkedSolves(const JobOptions& options, const Prepared& p, const Meshes& meshes)
      : options_(options),
        p_(p),
        meshes_(meshes),
        sources_(
            *p.scene, *p.optics,
            {p.effects.on(plan::Effect::kPointLights), p.effects.on(plan::Effect::kSpotLights),
             p.effects.on(plan::Effect::kDirectionalLights), p.effects.on(plan::Effect::kEmitters)},
            p.suns) {}

  bool has_light() const {
    return !sources_.punctual().empty() || !sources_.emitters().empty() || !p_.sky.is_black();
  }

  Result<Solved> solve(const hierarchy::Hierarchy& tree, double threshold,
                       const Progress& progress) const {
    const rays::Caster caster(tree, p_.scene->positions, meshes_.triangles, p_.optics->surfaces());
    const radiosity::DirectLight direct(*p_.optics, caster, sources_,
                                        p_.effects.on(plan::Effect::kShadows));
    radiosity::ElementOptions element_options;
    element_options.max_elements = kElements;
    const radiosity::Elements elements(*p_.scene, tree, *p_.optics, element_options);
    const radiosity::ElementLookup lookup(*p_.scene, caster, elements, direct.lift());
    radiosity::SolverOptions solver;
    solver.threshold = threshold;
    solver.seed = options_.seed;
    const auto start = std::chrono::steady_clock::now();
    LB_ASSIGN_OR_RETURN(const radiosity::Solution solution,
                        radiosity::solve_linked(
                            {*p_.scene, tree, *p_.optics, caster, elements, direct, p_.sky, lookup},
                            solver, progress));
    Solved solved;
    solved.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    solved.statistics = solution.statistics;
    for (std::uint32_t i = 0; i < kSamples; ++i) {
      Random random(item_seed(options_.seed, i, 11));
      const auto triangle = static_cast<std::uint32_t>(random.below(meshes_.triangles.size()));
      const float root = std::sqrt(random.next_float()), v = root * random.next_float();
      const radiosity::ElementId e = elements.at(triangle, root - v, v, false);
      solved.irradiance.push_back(
          e == radiosity::kNoElement ? 0.0 : static_cast<double>(solution.irradiance[e].sum()));
    }
    return solved;
  }

 private:
  const JobOptions& options_;
  const Prepared& p_;
  const Meshes& meshes_;
  radiosity::LightSources sources_;
};

/// Root mean square difference over the mean of the reference.
double difference(const std::vector<double>& values, const std::vector<double>& reference) {
  double squares = 0, sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    squares += (values[i] - reference[i]) * (values[i] - reference[i]);
    sum += reference[i];
  }
  const double n = static_cast<double>(values.size());
  return sum > 0 ? std::sqrt(squares / n) / (sum / n) : 0;
}

}  // namespace

Result<Json> compare_builders(const JobOptions& options, const Prepared& p,
                              const Progress& progress) {
  if (p.scene->triangles.empty()) return Json::array();
  const Meshes meshes = meshes_of(*p.scene);
  progress.report("compare", 0);
  rays::CompareOptions compare_options;
  compare_options.seed = options.seed;
  const std::vector<rays::ComparisonRow> rows = rays::compare(
      meshes.boxes, p.scene->positions, meshes.triangles, meshes.objects, compare_options);
  const LinkedSolves solves(options, p, meshes);
  Json result = Json::array();
  for (const rays::ComparisonRow& row : rows) {
    if (progress.cancelled()) return cancelled();
    progress.report("compare",
                    static_cast<double>(result.size() + 1) / static_cast<double>(rows.size() + 1));
    Json entry = {{"builder", row.name},
                  {"build_seconds", row.build_seconds},
                  {"sah_cost", row.sah_cost},
                  {"sah_cost_merged", row.sah_cost_merged},
                  {"overlap", row.overlap},
                  {"void_area", row.void_area},
                  {"depth", row.depth},
                  {"rays_per_second", row.rays_per_second},
                  {"grid_rays_per_second", row.grid_rays_per_second}};
    if (solves.has_light()) {
      const auto tree = hierarchy::build_with(row.method, meshes.boxes, meshes.objects);
      LB_ASSIGN_OR_RETURN(const Solved solved, solves.solve(*tree, kThreshold, progress));
      LB_ASSIGN_OR_RETURN(const Solved finer, solves.solve(*tree, kFinerThreshold, progress));
      entry["links"] = solved.statistics.links;
      entry["solve_seconds"] = solved.seconds;
      entry["error"] = difference(solved.irradiance, finer.irradiance);
    }
    result.push_back(std::move(entry));
  }
  return result;
}

std::string comparison_text(const Json& rows) {
  std::string text =
      "\nbuilder                      build s      SAH   merged  overlap    void  depth  "
      "Mrays/s  in grids     links  solve s   error\n";
  for (const Json& row : rows) {
    char line[256];
    std::snprintf(line, sizeof line, "%-27s %8.3f %8.2f %8.2f %8.3f %7.3f %6d %8.2f %9.2f",
                  row["builder"].get<std::string>().c_str(), row["build_seconds"].get<double>(),
                  row["sah_cost"].get<double>(), row["sah_cost_merged"].get<double>(),
                  row["overlap"].get<double>(), row["void_area"].get<double>(),
                  row["depth"].get<int>(), row["rays_per_second"].get<double>() * 1e-6,
                  row["grid_rays_per_second"].get<double>() * 1e-6);
    text += line;
    if (row.contains("links")) {
      std::snprintf(line, sizeof line, " %9llu %8.2f %7.4f",
                    static_cast<unsigned long long>(row["links"].get<std::uint64_t>()),
                    row["solve_seconds"].get<double>(), row["error"].get<double>());
      text += line;
    }
    text += "\n";
  }
  return text;
}

}  // namespace lightbatch::pipeline
