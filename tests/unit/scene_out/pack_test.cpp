#include "core/scene_out/pack.h"

#include <gtest/gtest.h>

#include "core/gltf/accessor.h"
#include "tests/unit/scene_out/files.h"

namespace lightbatch::scene_out {
namespace {

using testing::FileBuilder;
using testing::Json;
using testing::load;
using testing::write;

TEST(Pack, BytesOfMergedMeshesAreGone) {
  FileBuilder file;
  for (int i = 0; i < 40; ++i)
    file.node({{"mesh", file.mesh({file.cube()})}, {"translation", {2 * i, 0, 0}}});
  const auto in = load(file.glb());
  const auto out = write(in, true);
  // The same vertices, once; ranges and nodes cost some JSON.
  EXPECT_LT(testing::read(out.glb).buffers[0].size(),
            1.05 * static_cast<double>(in.document.buffers[0].size()));
}

/// One view with the positions of many meshes, as optimisers write: only what is read stays.
TEST(Pack, PartsOfSharedViewsAreDropped) {
  Json root{{"meshes", Json::array()}, {"accessors", Json::array()}, {"nodes", Json::array()}};
  Bytes buffer(12000);
  for (std::size_t i = 0; i < buffer.size(); ++i) buffer[i] = static_cast<std::byte>(i % 251);
  root["bufferViews"] = {{{"buffer", 0}, {"byteLength", 12000}, {"byteStride", 12}}};
  root["buffers"] = {{{"byteLength", 12000}}};
  for (int i = 0; i < 10; ++i) {
    root["accessors"].push_back({{"bufferView", 0},
                                 {"byteOffset", 1200 * i},
                                 {"count", 100},
                                 {"componentType", 5126},
                                 {"type", "VEC3"}});
    root["meshes"].push_back({{"primitives", {{{"attributes", {{"POSITION", i}}}}}}});
    root["nodes"].push_back({{"mesh", i}});
  }
  const Json before = root;
  for (const int i : {0, 1, 2, 4, 5, 6, 8, 9})
    root["nodes"][static_cast<std::size_t>(i)].erase("mesh");
  drop_meshes(root, before);
  const Bytes* buffers[] = {&buffer};
  const Bytes binary = pack(root, before, buffers);
  ASSERT_EQ(root["meshes"].size(), 2u);
  ASSERT_EQ(root["accessors"].size(), 2u);
  EXPECT_EQ(binary.size(), 2400u);
  EXPECT_EQ(root["nodes"][3]["mesh"], 0);
  EXPECT_EQ(root["nodes"][7]["mesh"], 1);
  for (int k = 0; k < 2; ++k) {
    const auto offset = root["accessors"][static_cast<std::size_t>(k)].value("byteOffset", 0);
    EXPECT_TRUE(std::equal(binary.begin() + offset, binary.begin() + offset + 1200,
                           buffer.begin() + (k == 0 ? 3600 : 8400)));
  }
}

/// A buffer without bytes is allowed where nothing is drawn from it; its length may be any lie.
TEST(Pack, BuffersWithoutDataAreLetGo) {
  FileBuilder file;
  file.node({{"mesh", file.mesh({file.cube()})}});
  Json& json = file.json;
  json["buffers"] = Json::array({Json::object(), {{"byteLength", 1ull << 50}}});
  const std::size_t view = json["bufferViews"].size();
  json["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 1ull << 50}});
  json["accessors"].push_back({{"bufferView", view},
                               {"byteOffset", 4},
                               {"componentType", 5121},
                               {"count", 9},
                               {"type", "SCALAR"}});
  json["images"] = {{{"bufferView", view}, {"mimeType", "image/png"}}};
  // Something that nobody understands counts on the numbers of views.
  for (const bool pinned : {false, true}) {
    if (pinned) {
      json["extensions"]["VENDOR_views"] = {{"bufferView", view}};
      json["extensionsUsed"] = {"VENDOR_views"};
    }
    const auto in = load(file.glb());
    const auto out = testing::read(write(in, true).glb);
    ASSERT_EQ(out.buffers.size(), 1u);
    EXPECT_LT(out.buffers[0].size(), 10'000u);
    EXPECT_FALSE(out.json["images"][0].contains("bufferView"));
    for (const Json& accessor : out.json["accessors"])
      EXPECT_NE(accessor.value("count", 0) == 9, accessor.contains("bufferView"));
    EXPECT_EQ(out.json["bufferViews"].size() > view, pinned);
  }
}

/// Numbers in extensions that nobody understands must still mean the same afterwards.
TEST(Pack, UnknownExtensionsPinWhatTheyMayMean) {
  FileBuilder file;
  for (int i = 0; i < 6; ++i) {
    file.node({{"mesh", file.mesh({file.cube()})}, {"translation", {2 * i, 0, 0}}});
    file.json["meshes"][static_cast<std::size_t>(i)]["name"] = "mesh " + std::to_string(i);
  }
  file.json["extensions"]["VENDOR_collision"] = {{"shapes", {{{"mesh", 4}}}}};
  file.json["extensionsUsed"] = {"VENDOR_collision"};
  const auto in = load(file.glb());
  const auto out = testing::read(write(in, true).glb);
  EXPECT_EQ(out.json["extensions"]["VENDOR_collision"],
            file.json["extensions"]["VENDOR_collision"]);
  ASSERT_GE(out.json["meshes"].size(), 5u);
  const Json& mesh = out.json["meshes"][4];
  EXPECT_EQ(mesh["name"], "mesh 4");
  const auto positions = *gltf::read_values(out, mesh["primitives"][0]["attributes"]["POSITION"]);
  const auto before = *gltf::read_values(
      in.document, file.json["meshes"][4]["primitives"][0]["attributes"]["POSITION"]);
  EXPECT_EQ(positions.data, before.data);
}

/// Sounds and profiles of lamps lie in views; so may what nobody understands.
TEST(Pack, ViewsOfExtensionsKeepTheirNumbersAndGeometryIsCompressed) {
  FileBuilder file;
  for (int i = 0; i < 30; ++i)
    file.node({{"mesh", file.mesh({file.cube()})}, {"translation", {2 * i, 0, 0}}});
  const auto view_of = [&](const std::string& text) {
    const std::uint32_t a =
        file.accessor(std::vector<char>(text.begin(), text.end()), 5120, "SCALAR");
    file.json["accessors"].erase(a);
    return file.json["bufferViews"].size() - 1;
  };
  const std::string sound = "a sound, as it is", profile = "IESNA:LM-63-1995", table = "a b c d";
  file.json["extensions"]["KHR_audio_emitter"] = {
      {"audio", {{{"bufferView", view_of(sound)}, {"mimeType", "audio/mpeg"}}}}};
  file.json["extensions"]["EXT_lights_ies"] = {
      {"lights", {{{"bufferView", view_of(profile)}, {"mimeType", "application/x-ies-lm-63"}}}}};
  file.json["extensions"]["VENDOR_table"] = {{"values", view_of(table)}};
  file.json["extensionsUsed"] = {"EXT_lights_ies", "KHR_audio_emitter", "VENDOR_table"};
  const auto in = load(file.glb());
  WriteOptions options;
  std::vector<std::size_t> sizes;
  for (const Compression compression :
       {Compression::kPlain, Compression::kMeshopt, Compression::kDraco}) {
    options.compression = compression;
    const Bytes glb = write(in, true, nullptr, {}, options).glb;
    sizes.push_back(glb.size());
    const auto out = testing::read(glb);
    EXPECT_EQ(out.json["extensions"], file.json["extensions"]);
    const Json& extensions = out.json["extensions"];
    for (const auto& [text, number] :
         {std::pair{sound, extensions["KHR_audio_emitter"]["audio"][0]["bufferView"]},
          {profile, extensions["EXT_lights_ies"]["lights"][0]["bufferView"]},
          {table, extensions["VENDOR_table"]["values"]}}) {
      ASSERT_LT(number.get<std::size_t>(), out.json["bufferViews"].size());
      const Json& view = out.json["bufferViews"][number.get<std::size_t>()];
      const Bytes& buffer = out.buffers[view["buffer"].get<std::size_t>()];
      const auto* at = reinterpret_cast<const char*>(buffer.data()) + view.value("byteOffset", 0);
      EXPECT_EQ(std::string(at, view["byteLength"].get<std::size_t>()), text);
    }
  }
  EXPECT_LT(sizes[1], sizes[0]);
  EXPECT_LT(sizes[2], sizes[0]);
}

}  // namespace
}  // namespace lightbatch::scene_out
