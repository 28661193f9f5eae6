/// Damaged scenes through the whole path from file to files, with options drawn at random.
/// LIGHTBATCH_FUZZ_SECONDS=600 goes on for so long; LIGHTBATCH_FUZZ_FIRST=123 begins at round 123;
/// LIGHTBATCH_FUZZ_KEEP=FILE writes each scene there before it is baked.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/pipeline/job.h"
#include "core/scene_in/read_scene.h"
#include "tests/fuzz/mutate.h"
#include "tests/fuzz/seeds.h"
#include "tests/unit/gltf/scene_files.h"

namespace lightbatch::fuzz {
namespace {

using Clock = std::chrono::steady_clock;
using gltf::Json;

constexpr std::uint64_t kRounds = 150;

double from_environment(const char* name) {
  const char* wish = std::getenv(name);
  return wish == nullptr ? 0 : std::atof(wish);
}

pipeline::JobOptions draw_options(Random& random) {
  pipeline::JobOptions options;
  options.target_error = 1;
  options.lightmap_size = 64;
  options.threads = 2;
  options.lightmaps = random.below(2) == 0;
  options.compression = static_cast<pipeline::Compression>(random.below(4));
  if (options.lightmaps) {
    options.carrier = static_cast<pipeline::Carrier>(random.below(3));
    options.lights = static_cast<pipeline::LightsPolicy>(random.below(2));
    if (random.below(2) == 0) options.sky_nits = 100;
  }
  options.batches = !options.lightmaps || random.below(4) != 0;
  options.pvs = options.batches && random.below(8) == 0;
  return options;
}

/// Pointer to a number that is not one: written as null.
std::string find_null(const Json& json, const std::string& at = {}) {
  if (json.is_null()) return at.empty() ? "/" : at;
  for (const auto& [key, value] : json.items()) {
    if (!value.is_structured() && !value.is_null()) continue;
    if (auto found = find_null(value, at + "/" + key); !found.empty()) return found;
  }
  return {};
}

Result<scene::Scene> read_back(const std::filesystem::path& file) {
  LB_ASSIGN_OR_RETURN(const gltf::Document document,
                      gltf::read_document({{"scene.glb", file}}, "scene.glb", {}));
  return scene_in::read_scene(document);
}

void check_artifacts(const std::filesystem::path& folder, const scene::Scene& before,
                     const pipeline::JobOptions& options) {
  const auto text = read_file(folder / "report.json");
  ASSERT_TRUE(text.ok());
  const Json report = Json::parse(as_text(*text), nullptr, false);
  ASSERT_FALSE(report.is_discarded());
  EXPECT_EQ(find_null(report), "");
  const auto after = read_back(folder / "scene.glb");
  ASSERT_TRUE(after.ok()) << after.status().to_string();
  if (options.carrier == pipeline::Carrier::kLightmap &&
      options.compression != pipeline::Compression::kDraco) {
    EXPECT_EQ(after->triangles.size(), before.triangles.size());
  } else if (!before.triangles.empty()) {
    EXPECT_FALSE(after->triangles.empty());
  }
  EXPECT_EQ(after->moving.size(), before.moving.size());
}

/// Whether it was baked rather than refused.
bool bake(const Bytes& file, gltf::SceneFiles& files, const pipeline::JobOptions& options,
          const std::filesystem::path& output) {
  files.add("scene.glb", file);
  std::filesystem::remove_all(output);
  std::filesystem::create_directories(output);
  const auto start = Clock::now();
  const auto outcome = pipeline::run_job(options, {files.map(), "scene.glb"}, output, {});
  EXPECT_LT(std::chrono::duration<double>(Clock::now() - start).count(), 60);
  if (!outcome.ok()) {
    const Status status = outcome.status();
    const bool told = status.reason().starts_with("INPUT_") ||
                      status.reason() == "SCENE_URI_FORBIDDEN" || status.reason() == "BAD_OPTION";
    EXPECT_TRUE(told && !status.message().empty()) << status.to_string();
    EXPECT_TRUE(std::filesystem::is_empty(output));
    return false;
  }
  const auto before = read_back(files.map().at("scene.glb"));
  EXPECT_TRUE(before.ok()) << before.status().to_string();
  if (before.ok()) check_artifacts(output, *before, options);
  return true;
}

/// Undamaged, they can be read: most of badinput/ would be refused for its own faults.
std::vector<Seed> good_seeds() {
  std::vector<Seed> good;
  gltf::SceneFiles files;
  for (Seed& seed : seeds()) {
    files.add("scene.glb", seed.file);
    if (files.read("scene.glb").ok()) good.push_back(std::move(seed));
  }
  return good;
}

TEST(BakeFuzz, DamagedScenesBakeOrAreRefused) {
  const std::vector<Seed> all = good_seeds();
  gltf::SceneFiles files;
  const char* keep = std::getenv("LIGHTBATCH_FUZZ_KEEP");
  const double seconds = from_environment("LIGHTBATCH_FUZZ_SECONDS");
  const auto first = static_cast<std::uint64_t>(from_environment("LIGHTBATCH_FUZZ_FIRST"));
  files.add("output/none", std::string_view());
  const std::filesystem::path output = files.map().at("output/none").parent_path();
  const auto start = Clock::now();
  std::uint64_t round = first, baked = 0;
  for (;; ++round) {
    const bool over = std::chrono::duration<double>(Clock::now() - start).count() >= seconds;
    if (round >= first + kRounds && over) break;
    Random random(item_seed(20261123, round));
    const Seed& seed = all[round % 3 == 0 ? 0 : random.below(all.size())];
    const pipeline::JobOptions options = draw_options(random);
    const Bytes damaged = damage(seed.file, seed.parts, random, 1 + random.below(3));
    if (keep != nullptr) {
      ASSERT_TRUE(write_file(keep, damaged).ok());
    }
    SCOPED_TRACE("round " + std::to_string(round) + " of " + seed.name);
    baked += bake(damaged, files, options, output) ? 1u : 0u;
    if (HasFailure() && seconds == 0) return;
  }
  std::printf("%llu of %llu scenes were baked\n", static_cast<unsigned long long>(baked),
              static_cast<unsigned long long>(round - first));
  EXPECT_GT(5 * baked, round - first) << "damage must leave something to bake";
}

}  // namespace
}  // namespace lightbatch::fuzz
