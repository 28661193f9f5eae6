/// Damaged scenes must end in a clear error or a finite scene, soon and in bounded memory. A few
/// thousand by default; LIGHTBATCH_FUZZ_SECONDS=600 goes on with new seeds for so long, and prints
/// the seed of what fails. Best run under the sanitizers.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "core/scene_in/read_scene.h"
#include "tests/fuzz/mutate.h"
#include "tests/fuzz/seeds.h"
#include "tests/unit/gltf/scene_files.h"

namespace lightbatch::fuzz {
namespace {

using Clock = std::chrono::steady_clock;

double peak_mebibytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// One damaged scene through reader and scene; checks what a result promises.
void run(const Bytes& file, gltf::SceneFiles& files, const std::string& name) {
  files.add("scene.glb", file);
  const auto start = Clock::now();
  const auto document = files.read("scene.glb");
  if (document.ok()) {
    const auto scene = scene_in::read_scene(*document);
    if (scene.ok()) {
      for (const Vec3f& position : scene->positions) ASSERT_TRUE(is_finite(position)) << name;
      for (const scene::Triangle& triangle : scene->triangles) {
        for (const std::uint32_t v : triangle.vertex) ASSERT_LT(v, scene->positions.size()) << name;
      }
      for (const scene::Light& light : scene->lights) {
        ASSERT_TRUE(is_finite(light.position) && is_finite(light.intensity)) << name;
      }
    } else {
      ASSERT_FALSE(scene.status().message().empty()) << name;
    }
  } else {
    ASSERT_FALSE(document.status().place().empty()) << name;
    ASSERT_FALSE(document.status().message().empty()) << name;
  }
  // Files of some kilobytes: a second is a hundred times what they take.
  ASSERT_LT(std::chrono::duration<double>(Clock::now() - start).count(), 10.0) << name;
}

TEST(SceneFuzz, TheSeedItselfIsGood) {
  gltf::SceneFiles files;
  files.add("scene.glb", rich_scene());
  const auto document = files.read("scene.glb");
  ASSERT_TRUE(document.ok()) << document.status().to_string();
  const auto scene = scene_in::read_scene(*document);
  ASSERT_TRUE(scene.ok()) << scene.status().to_string();
  EXPECT_EQ(scene->objects.size(), 3u);
  EXPECT_EQ(scene->moving.size(), 2u);
  EXPECT_EQ(scene->lights.size(), 1u);
}

TEST(SceneFuzz, DamagedScenesEndClearlyAndSoon) {
  const std::vector<Seed> all = seeds();
  gltf::SceneFiles files;
  const char* wish = std::getenv("LIGHTBATCH_FUZZ_SECONDS");
  const double seconds = wish == nullptr ? 0 : std::atof(wish);
  const auto start = Clock::now();
  const double memory_before = peak_mebibytes();
  std::uint64_t round = 0;
  for (;; ++round) {
    const bool over = std::chrono::duration<double>(Clock::now() - start).count() >= seconds;
    if (round >= 3000 && over) break;
    Random random(item_seed(20261122, round));
    // Half of the rounds go to the scene that uses most features.
    const Seed& seed = all[round % 2 == 0 ? 0 : random.below(all.size())];
    const std::string name = "round " + std::to_string(round) + " of " + seed.name;
    run(damage(seed.file, seed.parts, random), files, name);
    if (HasFatalFailure()) return;
  }
  RecordProperty("rounds", std::to_string(round));
  // 16 MiB of zeros, 256 MiB of pixels and what the sanitizers keep aside.
  EXPECT_LT(peak_mebibytes() - memory_before, 1500) << round;
}

}  // namespace
}  // namespace lightbatch::fuzz
