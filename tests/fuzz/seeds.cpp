#include "tests/fuzz/seeds.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <utility>

#include "tests/unit/gltf/scene_files.h"

namespace lightbatch::fuzz {

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
  constexpr std::uintmax_t kLargest = 20'000;  // bytes
  std::vector<std::filesystem::path> paths;
  const std::filesystem::path shared = LIGHTBATCH_SHARED;
  for (const auto& folder :
       {std::filesystem::path(LIGHTBATCH_TEST_DATA) / "reference", shared / "badinput"}) {
    if (!std::filesystem::exists(folder)) continue;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      const auto extension = entry.path().extension();
      if (!entry.is_regular_file() || entry.file_size() > kLargest) continue;
      // Light goes a thousand times round in these: each bake would take seconds.
      if (entry.path().stem().string().starts_with("furnace_0.99")) continue;
      if (extension == ".glb" || extension == ".gltf") paths.push_back(entry.path());
    }
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

}  // namespace lightbatch::fuzz
