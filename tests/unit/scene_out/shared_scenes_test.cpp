#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "core/gltf/accessor.h"
#include "tests/unit/scene_out/files.h"

namespace lightbatch::scene_out {
namespace {

using testing::Json;
using testing::Loaded;

// Large scenes have their own benchmarks.
constexpr std::uintmax_t kLargestFile = 4'000'000;

std::multiset<std::string> names_of(const Json& json) {
  std::multiset<std::string> names;
  for (const char* list : {"nodes", "animations", "cameras", "skins", "materials", "images"})
    if (json.contains(list))
      for (const Json& entry : json[list])
        if (entry.contains("name"))
          names.insert(std::string(list) + entry["name"].get<std::string>());
  return names;
}

std::vector<std::uint64_t> animation_keys(const Json& json) {
  std::vector<std::uint64_t> keys;
  if (json.contains("animations"))
    for (const Json& a : json["animations"])
      for (const Json& s : a["samplers"])
        keys.push_back(json["accessors"][s["input"].get<std::size_t>()]["count"]);
  return keys;
}

std::vector<float> bind_matrices(const gltf::Document& document) {
  std::vector<float> all;
  if (document.json.contains("skins"))
    for (const Json& s : document.json["skins"])
      if (s.contains("inverseBindMatrices")) {
        const auto values = *gltf::read_values(document, s["inverseBindMatrices"]);
        all.insert(all.end(), values.data.begin(), values.data.end());
      }
  return all;
}

/// What every rewritten file must keep of its input.
void expect_kept(const Loaded& in, const testing::Written& written) {
  const Loaded out = testing::load(written.glb);
  EXPECT_EQ(animation_keys(out.document.json), animation_keys(in.document.json));
  EXPECT_EQ(bind_matrices(out.document), bind_matrices(in.document));
  const auto before = names_of(in.document.json), after = names_of(out.document.json);
  for (const std::string& name : before) EXPECT_GE(after.count(name), before.count(name)) << name;
  const Json& nodes = in.document.json["nodes"];
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (!nodes[n].contains("extras")) continue;
    EXPECT_EQ(out.document.json["nodes"][n]["extras"], nodes[n]["extras"]);
  }
  EXPECT_EQ(out.scene.skipped.size(), in.scene.skipped.size());
  // A few triangles at the edge of having no area may fall on the other side of it.
  const auto a = testing::world_triangles(in), b = testing::world_triangles(out);
  if (a.size() != b.size()) {
    EXPECT_NEAR(static_cast<double>(a.size()), static_cast<double>(b.size()),
                2 + 1e-3 * static_cast<double>(a.size()));
    return;
  }
  const double size = static_cast<double>(in.scene.box.diagonal());
  // Float positions of the input, turned and stored again: a few ulp of the scene's size. Quantised
  // ones may move by what the writer says, a step of their own grid at most.
  const double moved = written.facts.position_error;
  EXPECT_LE(moved, 1e-4 * size);
  EXPECT_LE(testing::largest_distance(a, b, 1e-5 * size + 2 * moved), 1e-6 * size + moved);
}

TEST(SharedScenes, KeepEverything) {
  const std::filesystem::path folder = std::filesystem::path(LIGHTBATCH_SHARED) / "scenes";
  if (!std::filesystem::exists(folder)) return;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".glb" || entry.file_size() > kLargestFile) continue;
    SCOPED_TRACE(entry.path().filename());
    auto bytes = read_file(entry.path());
    ASSERT_TRUE(bytes.ok());
    const Loaded in = testing::load(*bytes);
    expect_kept(in, testing::write(in, true));
    const atlas::Layout layout = testing::simple_layout(in.scene, 2);
    expect_kept(in, testing::write(in, true, &layout));
    expect_kept(in, testing::write(in, false, &layout));
  }
}

}  // namespace
}  // namespace lightbatch::scene_out
