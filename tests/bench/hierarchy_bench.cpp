// Construction and casting beside Embree 3 (MEDIUM) in one run.
//
// hierarchy_bench [--scenes a,b] [--repetitions 5] [--rays 131072] [--checks 200000]
//                 [--soups DIR] [--sections build,threads,checks,rays,bundles,grids,growth]
//
// --soups: folder of classroom.soup and hotel_room.soup (count, then nine floats a triangle).
// --checks: rays that the oracle judges in each scene, on all threads: --sections checks --checks
// 20000000 makes 10^8 of the five scenes. growth: 10 k to 10 M.
// A table of all scenes ends the run.
// Times are medians of CPU time with one thread (other programs disturb it less than wall time);
// rates are million rays a second. Ratios are to Embree in the same run; above 1 is faster.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "core/base/parallel.h"
#include "core/hierarchy/hierarchy.h"
#include "core/hierarchy/statistics.h"
#include "core/rays/caster.h"
#include "tests/bench/bench_checks.h"
#include "tests/bench/bench_rays.h"
#include "tests/bench/bench_scenes.h"
#include "tests/bench/bench_table.h"
#include "tests/bench/embree_peer.h"

namespace lightbatch::bench {
namespace {

int repetitions = 5;
std::size_t ray_count = 131072;
std::size_t check_count = 200000;
std::string sections = "build,threads,checks,rays,bundles";
BenchTable table;

constexpr std::size_t kLeakRays = 2000000;

bool wants(const char* section) { return sections.find(section) != std::string::npos; }

double seconds(clockid_t clock) {
  timespec t;
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Runs the programs in turn, so that all see the same disturbance; medians.
std::vector<double> timed(const std::vector<std::function<void()>>& programs,
                          clockid_t clock = CLOCK_PROCESS_CPUTIME_ID) {
  std::vector<std::vector<double>> times(programs.size());
  for (int r = 0; r < repetitions; ++r) {
    for (std::size_t i = 0; i < programs.size(); ++i) {
      const double start = seconds(clock);
      programs[i]();
      times[i].push_back(seconds(clock) - start);
    }
  }
  std::vector<double> medians;
  for (auto& list : times) medians.push_back(median(std::move(list)));
  return medians;
}

/// 16 segments between two triangles: what a link knows, against Embree's best way of calling.
void compare_bundles(const Scene& scene, const rays::Caster& caster, const RaySet& set,
                     const EmbreePeer& embree) {
  using Way = EmbreePeer::Way;
  std::vector<rays::Segment> segments;
  for (const rays::Ray& ray : set.rays) segments.push_back({ray});
  std::vector<std::uint32_t> stopped(segments.size() / 16);
  std::size_t hits = 0;
  const auto times =
      timed({[&] {
               hits = 0;
               caster.occluded(segments, stopped);
               for (const std::uint32_t s : stopped) {
                 hits += static_cast<std::size_t>(std::popcount(s));
               }
             },
             [&] { embree.cast(set, Way::kPacket8); }, [&] { embree.cast(set, Way::kPacket16); },
             [&] { embree.cast(set, Way::kStream); }});
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < set.rays.size(); ++i) {
    wrong += caster.occluded(set.rays[i]) == ((stopped[i / 16] >> (i % 16) & 1u) != 0) ? 0u : 1u;
  }
  if (wrong > 0) std::printf("bundles: %zu answers are not those of single rays\n", wrong);
  table.add("bundles, answers unlike single rays", "0", scene.name, static_cast<double>(wrong));
  const double rays = static_cast<double>(set.rays.size()) * 1e-6;
  const double best = std::min({times[1], times[2], times[3]});
  std::printf("bundle16 %5.2f, Embree's best %5.2f; ratio %.2f; hits %zu\n", rays / times[0],
              rays / best, best / times[0], hits);
  table.add("16-ray bundles / Embree's best way", ">= 2", scene.name, best / times[0]);
}

void print_two_threads(const Scene& scene) {
  const auto build = [&] { hierarchy::build(scene.boxes, {.reinsertion = false}); };
  set_thread_count(1);
  const double one = timed({build}, CLOCK_MONOTONIC)[0];
  set_thread_count(2);
  const double two = timed({build}, CLOCK_MONOTONIC)[0];
  set_thread_count(1);
  std::printf("sweep on two threads: %.2f times as fast (wall time)\n", one / two);
  table.add("sweep, two threads against one", ">= 1.7", scene.name, one / two);
}

void print_checks(const Scene& scene, const hierarchy::Hierarchy& tree,
                  const rays::Caster& caster) {
  set_thread_count(2);
  const Wrong wrong = check_against_oracle(scene, tree, caster, check_count);
  set_thread_count(1);
  std::printf("oracle: %zu wrong of %zu rays (%zu in doubt)\n", wrong.wrong, wrong.rays,
              wrong.doubtful);
  table.add("wrong answers by the oracle", "0", scene.name, static_cast<double>(wrong.wrong));
  if (scene.name == "torus") {
    const std::size_t leaks = count_leaks(scene, caster, kLeakRays);
    std::printf("leaks: %zu of %zu rays at vertices and edges\n", leaks, kLeakRays);
    table.add("leaks of 2 M rays at edges", "0", scene.name, static_cast<double>(leaks));
  }
}

void print_build(const Scene& scene, EmbreePeer& embree) {
  const auto n = static_cast<double>(scene.triangles.size());
  hierarchy::Hierarchy sweep, tree;
  const auto build = timed({[&] { embree.build(); },
                            [&] { sweep = hierarchy::build(scene.boxes, {.reinsertion = false}); },
                            [&] { tree = hierarchy::build(scene.boxes); }});
  const hierarchy::Statistics swept = measure(sweep), final = measure(tree);
  std::printf(
      "build ns/primitive: Embree %.0f; sweep %.0f (%.2f of it); with reinsertion %.0f (%.2f)\n",
      build[0] / n * 1e9, build[1] / n * 1e9, build[1] / build[0], build[2] / n * 1e9,
      build[2] / build[0]);
  table.add("sweep / Embree MEDIUM, time", "<= 0.40", scene.name, build[1] / build[0]);
  table.add("with reinsertion / Embree, time", "<= 0.8", scene.name, build[2] / build[0]);
  table.add("SAH cost", "31.9 / 51.6", scene.name, final.sah_cost_merged);
  table.add("SAH cost of Embree MEDIUM", "", scene.name, embree.sah_cost());
  std::printf("SAH cost, merged: Embree %.2f; sweep %.2f; with reinsertion %.2f; depth %d, %d\n",
              embree.sah_cost(), swept.sah_cost_merged, final.sah_cost_merged, swept.depth,
              final.depth);
}

void print_rays(const Scene& scene, const rays::Caster& caster, const EmbreePeer& embree) {
  using Way = EmbreePeer::Way;
  for (const RaySet& set : make_rays(scene, caster, ray_count)) {
    if (set.name == "ff16" && wants("bundles")) compare_bundles(scene, caster, set, embree);
    if (!wants("rays")) continue;
    std::size_t own = 0, single = 0;
    std::vector<std::function<void()>> programs{
        [&] {
          own = 0;
          for (const rays::Ray& ray : set.rays) {
            own += set.any ? caster.occluded(ray) : caster.closest(ray).found();
          }
        },
        [&] { single = embree.cast(set, Way::kSingle); }, [&] { embree.cast(set, Way::kPacket8); },
        [&] { embree.cast(set, Way::kPacket16); }, [&] { embree.cast(set, Way::kStream); }};
    const auto times = timed(programs);
    const double rays = static_cast<double>(set.rays.size()) * 1e-6;
    std::printf(
        "%-8s single %5.2f, Embree %5.2f (8: %.2f, 16: %.2f, stream: %.2f); ratio %.2f; hits "
        "%zu, %zu\n",
        set.name.c_str(), rays / times[0], rays / times[1], rays / times[2], rays / times[3],
        rays / times[4], times[1] / times[0], own, single);
    if (set.name == "pair" || set.name == "bounce") {
      table.add(set.name + ", single ray / Embree MEDIUM", ">= 1.0", scene.name,
                times[1] / times[0]);
    }
  }
}

/// The casting tree without grids, with those that the rule chooses, and with as many as there can
/// be.
void compare_grids(const Scene& scene, const hierarchy::Hierarchy& tree) {
  using rays::Grids;
  std::vector<rays::Caster> casters;
  for (const Grids grids : {Grids::kNever, Grids::kWhereCheaper, Grids::kEverywhere}) {
    casters.emplace_back(tree, scene.positions, scene.triangles, std::span<const rays::Surface>(),
                         grids);
  }
  for (const RaySet& set : make_rays(scene, casters[0], ray_count)) {
    std::vector<std::function<void()>> programs;
    std::vector<std::size_t> hits(casters.size());
    for (std::size_t i = 0; i < casters.size(); ++i) {
      programs.push_back([&, i] {
        hits[i] = 0;
        for (const rays::Ray& ray : set.rays) {
          hits[i] += set.any ? casters[i].occluded(ray) : casters[i].closest(ray).found();
        }
      });
    }
    const auto times = timed(programs);
    const double rays = static_cast<double>(set.rays.size()) * 1e-6;
    std::printf("%-8s no grids %5.2f; %zu grids by cost: %.2f times; %zu wherever: %.2f times\n",
                set.name.c_str(), rays / times[0], casters[1].grids().size(), times[0] / times[1],
                casters[2].grids().size(), times[0] / times[2]);
    if (hits[1] != hits[0] || hits[2] != hits[0]) std::printf("grids change the answers\n");
    if (set.name == "pair" || set.name == "bounce") {
      table.add(set.name + ", grids by cost / none", ">= 1.0", scene.name, times[0] / times[1]);
      table.add(set.name + ", grids wherever / none", "", scene.name, times[0] / times[2]);
    }
  }
  for (const rays::GridNode& grid : casters[1].grids()) {
    std::printf("grid: node %u, %u triangles, %u cells, expected cost %.2f of the tree's\n",
                grid.node, grid.triangles, grid.cells, static_cast<double>(grid.cost_share));
  }
}

void run(const Scene& scene) {
  std::printf("\n== %s: %zu triangles\n", scene.name.c_str(), scene.triangles.size());
  set_thread_count(1);
  EmbreePeer embree(scene, 1);
  if (wants("build")) {
    print_build(scene, embree);
  } else {
    embree.build();
  }
  if (wants("threads")) print_two_threads(scene);
  if (!wants("checks") && !wants("rays") && !wants("bundles") && !wants("grids")) return;
  const hierarchy::Hierarchy tree = hierarchy::build(scene.boxes);
  if (wants("grids")) compare_grids(scene, tree);
  if (!wants("checks") && !wants("rays") && !wants("bundles")) return;
  const rays::Caster caster(tree, scene.positions, scene.triangles, {});
  const auto n = static_cast<double>(scene.triangles.size());
  const double casting = static_cast<double>(caster.memory_bytes()) / n;
  hierarchy::Hierarchy compact = tree;
  const double start = seconds(CLOCK_PROCESS_CPUTIME_ID);
  compact.compact();
  const double spent = seconds(CLOCK_PROCESS_CPUTIME_ID) - start;
  const double binary = static_cast<double>(compact.memory_bytes()) / n;
  std::printf(
      "bytes/triangle: Embree %.1f + 48 of buffers; casting tree %.1f; binary tree %.1f, compacted "
      "%.1f in %.1f ns\n",
      embree.bytes_per_triangle(), casting, static_cast<double>(tree.memory_bytes()) / n, binary,
      spent / n * 1e9);
  table.add("casting tree, bytes a triangle", "<= 60", scene.name, casting);
  table.add("binary tree kept, bytes a triangle", "<= 40", scene.name, binary);
  if (wants("checks")) print_checks(scene, tree, caster);
  if (wants("rays") || wants("bundles")) print_rays(scene, caster, embree);
}

/// Time a primitive over log2 n, and memory, from ten thousand to ten million triangles.
void print_growth() {
  std::printf("\n== growth (torus, needles): ns a primitive, the same over log2 n, bytes\n");
  for (const bool torus : {true, false}) {
    double least = 1e300, most = 0;
    for (const std::size_t n : {10000u, 100000u, 1000000u, 10000000u}) {
      const Scene scene = torus ? make_torus(n) : make_needles(n);
      const auto count = static_cast<double>(scene.boxes.size());
      std::size_t bytes = 0;
      const double seconds =
          timed({[&] { bytes = hierarchy::build(scene.boxes).memory_bytes(); }})[0];
      const double each = seconds / count * 1e9, over_log = each / std::log2(count);
      least = std::min(least, over_log);
      most = std::max(most, over_log);
      std::printf("%-8s %9zu  %7.1f  %6.2f  %5.1f\n", scene.name.c_str(), scene.boxes.size(), each,
                  over_log, static_cast<double>(bytes) / count);
    }
    table.add("growth over n log n, most / least", "<= 1.3", torus ? "torus" : "needles",
              most / least);
  }
}

}  // namespace
}  // namespace lightbatch::bench

int main(int argc, char** argv) {
  using namespace lightbatch::bench;
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);  // long runs into files can be watched
  std::string wanted = "classroom,hotel_room,office,torus,needles", soups = ".";
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    if (name == "--scenes") wanted = argv[i + 1];
    if (name == "--sections") sections = argv[i + 1];
    if (name == "--soups") soups = argv[i + 1];
    if (name == "--repetitions") repetitions = std::max(1, std::atoi(argv[i + 1]));
    if (name == "--checks") check_count = static_cast<std::size_t>(std::atoll(argv[i + 1]));
    if (name == "--rays") ray_count = static_cast<std::size_t>(std::atoll(argv[i + 1]));
  }
  for (const std::string name :
       {"classroom", "hotel_room", "office", "torus", "needles", "swarm"}) {
    if (wanted.find(name) == std::string::npos) continue;
    const Scene scene = name == "office"    ? make_office(1000000)
                        : name == "torus"   ? make_torus(1000000)
                        : name == "needles" ? make_needles(200000)
                        : name == "swarm"   ? make_swarm(200000)
                                            : load_soup(soups + "/" + name + ".soup", name);
    if (!scene.triangles.empty()) run(scene);
  }
  if (wants("growth")) print_growth();
  table.print();
  return 0;
}
