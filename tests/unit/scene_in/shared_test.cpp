/// The wider sets, when they lie beside the project: hostile files with the outcome promised for
/// each, and real scenes with their triangle counts.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <string>

#include "tests/unit/scene_in/scene_builder.h"

namespace lightbatch::scene_in {
namespace {

const std::filesystem::path kShared = LIGHTBATCH_SHARED;

struct Outcome {
  Status status;
  std::vector<std::string> warnings;
  scene::Scene scene;
};

/// Reads one file with everything in its folder at hand, as an upload of the folder would.
Outcome read_file_of(const std::filesystem::path& path) {
  gltf::FileMap files;
  const std::filesystem::path folder = path.parent_path();
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      files[std::filesystem::relative(entry.path(), folder).string()] = entry.path();
    }
  }
  Outcome outcome;
  const auto document = gltf::read_document(files, path.filename().string());
  if (!document.ok()) {
    outcome.status = document.status();
    return outcome;
  }
  outcome.warnings = document->warnings;
  auto scene = read_scene(*document);
  if (!scene.ok()) {
    outcome.status = scene.status();
    return outcome;
  }
  outcome.scene = std::move(scene).value();
  for (const std::string& warning : outcome.scene.warnings) {
    if (warning.find("has no scene") == std::string::npos) outcome.warnings.push_back(warning);
  }
  return outcome;
}

void expect_finite(const scene::Scene& scene, const std::string& file) {
  bool finite = is_finite(scene.origin);
  for (const Vec3f& position : scene.positions) finite = finite && is_finite(position);
  for (const Vec2f& uv : scene.uv0) finite = finite && std::isfinite(uv.x) && std::isfinite(uv.y);
  for (const scene::Material& material : scene.materials) {
    finite = finite && is_finite(material.base_color) && is_finite(material.emission) &&
             std::isfinite(material.alpha_cutoff);
  }
  for (const scene::Light& light : scene.lights) {
    finite = finite && is_finite(light.position) && is_finite(light.direction) &&
             is_finite(light.intensity);
  }
  EXPECT_TRUE(finite) << file;
  for (const scene::Triangle& triangle : scene.triangles) {
    for (const std::uint32_t vertex : triangle.vertex) ASSERT_LT(vertex, scene.positions.size());
    ASSERT_LT(triangle.object, scene.objects.size());
  }
}

TEST(Shared, HostileFilesEndAsPromised) {
  std::ifstream table(kShared / "badinput" / "expected.tsv");
  std::string line;
  std::getline(table, line);  // heading
  while (std::getline(table, line)) {
    const std::size_t tab = line.find('\t');
    const std::string file = line.substr(0, tab);
    const std::string expected = line.substr(tab + 1, line.find('\t', tab + 1) - tab - 1);
    const Outcome outcome = read_file_of(kShared / "badinput" / file);
    const std::string got = file + ": " + outcome.status.to_string();
    if (expected == "reject" || expected == "refuse") {
      EXPECT_FALSE(outcome.status.ok()) << got;
    } else if (expected == "load") {
      EXPECT_TRUE(outcome.status.ok()) << got;
    } else if (expected == "diagnose") {
      EXPECT_TRUE(!outcome.status.ok() || !outcome.warnings.empty()) << got;
    } else if (expected == "load-or-refuse") {
      EXPECT_TRUE(outcome.status.ok() || outcome.status.reason() == "INPUT_UNSUPPORTED") << got;
    } else {
      EXPECT_EQ(expected, "nocrash") << file;
    }
    if (!outcome.status.ok()) {
      EXPECT_FALSE(outcome.status.place().empty()) << got;
      EXPECT_FALSE(outcome.status.message().empty()) << got;
    }
    expect_finite(outcome.scene, file);
  }
}

TEST(Shared, ScenesHaveTheirTriangles) {
  // What the default scene draws, from the set's own table; LINES and what moves are not triangles
  // of ours.
  const std::map<std::string, std::uint64_t> drawn = {
      {"banana_tree.mask", 867},
      {"classroom", 111162},
      {"cornell_bevy_uv1", 36},
      {"cornell_measured", 32},
      {"depth_of_field", 10610},
      {"folio_areas.draco_basisu", 60825},
      {"folio_areas", 60913},
      {"fox.skinned", 576},
      {"home_theater", 7915},
      {"home_theater.quantized", 7915},
      {"hotel_block_1m.draco", 1188348},
      {"hotel_block_instanced", 4753392},
      {"hotel_room", 99029},
      {"hotel_room.meshopt", 99029},
      {"littlest_tokyo.draco", 141800},
      {"mixed_lighting", 40898},
      {"morph_stress", 2412},
      {"simple_instancing.gpu", 1500},
      {"small_room.draco_webp", 47402},
      {"small_room", 47402},
      {"sparse_morph_cube", 12},
      {"truck_town.webp", 30477},
      {"vianney_house", 56674},
      {"vianney_house_garden", 264754},
      {"vianney_house_garden.gpu_instancing", 264754},
  };
  for (const auto& [name, triangles] : drawn) {
    const std::filesystem::path path = kShared / "scenes" / (name + ".glb");
    if (!std::filesystem::exists(path)) continue;
    const Outcome outcome = read_file_of(path);
    ASSERT_TRUE(outcome.status.ok()) << name << ": " << outcome.status.to_string();
    const scene::Scene& scene = outcome.scene;
    expect_finite(scene, name);
    const std::uint64_t read = scene.triangles.size() + scene.counts.zero_area_triangles;
    const bool moves = !scene.moving.empty();
    if (moves) {
      EXPECT_LT(read, triangles) << name;
    } else {
      EXPECT_EQ(read, triangles) << name;
    }
    std::uint32_t next = 0;
    for (const scene::Object& object : scene.objects) {
      EXPECT_EQ(object.first_triangle, next) << name;
      next += object.triangle_count;
    }
    EXPECT_EQ(next, scene.triangles.size()) << name;
  }
}

}  // namespace
}  // namespace lightbatch::scene_in
