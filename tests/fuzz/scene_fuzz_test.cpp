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
#include "tests/unit/gltf/scene_files.h"

namespace lightbatch::fuzz {
namespace {

using Clock = std::chrono::steady_clock;

struct Seed {
  std::string name;
  Bytes file;
  std::optional<Parts> parts;
};

/// Much in little: instances, lights, textures, a skin, morph targets, animation, sparse values.
Bytes rich_scene() {
  gltf::SceneBuilder builder;
  builder.square();
  gltf::Json& json = builder.json;
  const std::size_t uv = builder.accessor(std::vector<float>{0, 1, 1, 1, 1, 0, 0, 0}, "VEC2", 2);
  const std::size_t offsets = builder.accessor(std::vector<float>(12, 0.25f), "VEC3", 3);
  const std::size_t places = builder.accessor(std::vector<float>{0, 0, 0, 3, 0, 0}, "VEC3", 3);
  const std::size_t times = builder.accessor(std::vector<float>{0, 1}, "SCALAR", 1);
  const std::size_t joints = builder.accessor(std::vector<std::uint8_t>(16, 0), "VEC4", 4);
  const std::size_t weights = builder.accessor(std::vector<float>(16, 0.25f), "VEC4", 4);
  builder.primitive()["attributes"]["TEXCOORD_0"] = uv;
  builder.primitive()["material"] = 0;
  gltf::Json moving = builder.primitive();
  moving["targets"] = {{{"POSITION", offsets}}};
  gltf::Json skinned = builder.primitive();
  skinned["attributes"]["JOINTS_0"] = joints;
  skinned["attributes"]["WEIGHTS_0"] = weights;
  json["meshes"].push_back({{"primitives", gltf::Json::array({moving})}});
  json["meshes"].push_back({{"primitives", gltf::Json::array({skinned})}});
  json["accessors"][2]["sparse"] = {
      {"count", 1},
      {"indices",
       {{"bufferView", builder.view(std::vector<std::uint8_t>{2})}, {"componentType", 5121}}},
      {"values", {{"bufferView", builder.view(std::vector<float>{0.5f, 0.5f})}}}};
  json["extensionsUsed"] = {"KHR_lights_punctual", "EXT_mesh_gpu_instancing",
                            "KHR_texture_transform"};
  json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "spot"}, {"spot", {{"outerConeAngle", 1}}}}};
  json["materials"] = {
      {{"emissiveFactor", {1, 1, 1}},
       {"alphaMode", "MASK"},
       {"emissiveTexture",
        {{"index", 0}, {"extensions", {{"KHR_texture_transform", {{"rotation", 1}}}}}}}}};
  json["textures"] = {{{"source", 0}}};
  json["images"] = {{{"bufferView", 0}, {"mimeType", "image/png"}}};
  json["skins"] = {{{"joints", {1}}}};
  json["nodes"] = {{{"mesh", 0}, {"children", {1, 2}}, {"scale", {1, -2, 1}}},
                   {{"mesh", 1}},
                   {{"mesh", 2}, {"skin", 0}},
                   {{"mesh", 0}},
                   {{"translation", {0, 0, 1}}}};
  json["nodes"][3]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = places;
  json["nodes"][4]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  json["scenes"][0]["nodes"] = {0, 3, 4};
  json["animations"] = {
      {{"channels", {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "translation"}}}}}},
       {"samplers", {{{"input", times}, {"output", places}}}}}};
  return builder.glb();
}

std::vector<Seed> seeds() {
  std::vector<Seed> found;
  const auto add = [&found](std::string name, Bytes file) {
    std::optional<Parts> parts = split(file);
    found.push_back({std::move(name), std::move(file), std::move(parts)});
  };
  add("rich", rich_scene());
  const std::filesystem::path shared = LIGHTBATCH_SHARED;
  if (!std::filesystem::exists(shared / "badinput")) return found;
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(shared / "badinput")) {
    const auto extension = entry.path().extension();
    if (!entry.is_regular_file() || entry.file_size() > 20'000) continue;
    if (extension == ".glb" || extension == ".gltf") paths.push_back(entry.path());
  }
  for (const char* name : {"simple_instancing.gpu.glb", "sparse_morph_cube.glb",
                           "cornell_bevy_uv1.glb", "cornell_measured.glb"}) {
    if (std::filesystem::exists(shared / "scenes" / name))
      paths.push_back(shared / "scenes" / name);
  }
  std::sort(paths.begin(), paths.end());
  for (const auto& path : paths) {
    auto file = read_file(path);
    if (file.ok()) add(path.string(), std::move(file).value());
  }
  return found;
}

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
