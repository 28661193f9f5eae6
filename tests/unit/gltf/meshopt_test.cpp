#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include "core/gltf/accessor.h"
#include "tests/unit/gltf/scene_files.h"

namespace lightbatch::gltf {
namespace {

constexpr const char* kMeshopt = "EXT_meshopt_compression";

template <typename T>
Bytes vertex_code(const std::vector<T>& values, std::size_t stride) {
  const std::size_t count = values.size() * sizeof(T) / stride;
  Bytes code(meshopt_encodeVertexBufferBound(count, stride));
  code.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(code.data()), code.size(),
                                         values.data(), count, stride));
  return code;
}

/// A square whose positions and indices are compressed, over a fallback buffer without bytes.
class CompressedSquare {
 public:
  CompressedSquare() {
    positions = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    indices = {0, 1, 2, 0, 2, 3};
    Bytes index_code(meshopt_encodeIndexBufferBound(6, 4));
    index_code.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(index_code.data()),
                                                index_code.size(), indices.data(), 6));
    Json& json = builder.json;
    json["bufferViews"] = Json::array();
    add(vertex_code(positions, 12), 4, 12, "ATTRIBUTES");
    add(index_code, 6, 4, "TRIANGLES");
    json["accessors"] = {
        {{"bufferView", 0}, {"componentType", 5126}, {"count", 4}, {"type", "VEC3"}},
        {{"bufferView", 1}, {"componentType", 5125}, {"count", 6}, {"type", "SCALAR"}}};
    json["meshes"] = Json::array(
        {{{"primitives", Json::array({{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}})}}});
    json["extensionsUsed"] = {kMeshopt};
    json["extensionsRequired"] = {kMeshopt};
    finish();
  }

  /// Appends compressed data and the view that stands for what it decodes to.
  void add(const Bytes& code, std::size_t count, std::size_t stride, const char* mode) {
    builder.binary.resize((builder.binary.size() + 3) / 4 * 4);
    Json view = {{"buffer", 1}, {"byteOffset", fallback_}, {"byteLength", count * stride}};
    if (std::string_view(mode) == "ATTRIBUTES") view["byteStride"] = stride;
    view["extensions"][kMeshopt] = {{"buffer", 0},
                                    {"byteOffset", builder.binary.size()},
                                    {"byteLength", code.size()},
                                    {"byteStride", stride},
                                    {"count", count},
                                    {"mode", mode}};
    builder.json["bufferViews"].push_back(view);
    builder.binary.insert(builder.binary.end(), code.begin(), code.end());
    fallback_ += (count * stride + 3) / 4 * 4;
  }
  void finish() {
    builder.json["buffers"] = {{{"byteLength", builder.binary.size()}},
                               {{"byteLength", fallback_}}};
    builder.json["buffers"][1]["extensions"][kMeshopt]["fallback"] = true;
  }
  Json& extension(std::size_t view) {
    return builder.json["bufferViews"][view]["extensions"][kMeshopt];
  }

  SceneBuilder builder;
  std::vector<float> positions;
  std::vector<std::uint32_t> indices;

 private:
  std::size_t fallback_ = 0;
};

TEST(Meshopt, DecodesToPlainGltf) {
  CompressedSquare square;
  const auto document = square.builder.read();
  ASSERT_TRUE(document.ok()) << document.status().to_string();
  EXPECT_TRUE(document->had_meshopt);
  EXPECT_FALSE(document->json.contains("extensionsUsed"));
  EXPECT_EQ(read_values(*document, 0)->data, square.positions);
  EXPECT_EQ(*read_indices(*document, 1), square.indices);
  // The fallback buffer is gone: what remains is the compressed one and the decoded one.
  ASSERT_EQ(document->buffers.size(), 2u);
  ASSERT_EQ(document->json["buffers"].size(), 2u);
  EXPECT_EQ(document->buffers[1].size(), document->json["buffers"][1]["byteLength"]);
  for (const Json& view : document->json["bufferViews"]) {
    EXPECT_FALSE(view.contains("extensions"));
    EXPECT_EQ(view["buffer"], 1);
  }
}

TEST(Meshopt, SequencesAndFilters) {
  CompressedSquare square;
  const std::vector<std::uint32_t> sequence = {5, 6, 7, 100, 0, 9};
  Bytes code(meshopt_encodeIndexSequenceBound(6, 1000));
  code.resize(meshopt_encodeIndexSequence(reinterpret_cast<unsigned char*>(code.data()),
                                          code.size(), sequence.data(), 6));
  square.add(code, 6, 2, "INDICES");

  const float normals[] = {0, 0, 1, 0, 0.6f, 0, 0.8f, 0};
  std::vector<std::int8_t> octahedral(8);
  meshopt_encodeFilterOct(octahedral.data(), 2, 4, 8, normals);
  square.add(vertex_code(octahedral, 4), 2, 4, "ATTRIBUTES");
  square.extension(3)["filter"] = "OCTAHEDRAL";

  const float turn[] = {0, 0.6f, 0, 0.8f};
  std::vector<std::int16_t> quaternion(4);
  meshopt_encodeFilterQuat(quaternion.data(), 1, 8, 16, turn);
  square.add(vertex_code(quaternion, 8), 1, 8, "ATTRIBUTES");
  square.extension(4)["filter"] = "QUATERNION";

  const float floats[] = {0.5f, -3.0f, 1000.0f, 0.001f};
  std::vector<std::uint32_t> exponential(4);
  meshopt_encodeFilterExp(exponential.data(), 1, 16, 20, floats);
  square.add(vertex_code(exponential, 16), 1, 16, "ATTRIBUTES");
  square.extension(5)["filter"] = "EXPONENTIAL";
  square.finish();

  Json& accessors = square.builder.json["accessors"];
  accessors.push_back(
      {{"bufferView", 2}, {"componentType", 5123}, {"count", 6}, {"type", "SCALAR"}});
  accessors.push_back({{"bufferView", 3}, {"componentType", 5120}, {"count", 2}, {"type", "VEC3"}});
  accessors.push_back({{"bufferView", 4}, {"componentType", 5122}, {"count", 1}, {"type", "VEC4"}});
  accessors.push_back({{"bufferView", 5}, {"componentType", 5126}, {"count", 1}, {"type", "VEC4"}});
  for (const std::size_t a : {3u, 4u}) accessors[a]["normalized"] = true;
  const auto document = square.builder.read();
  ASSERT_TRUE(document.ok()) << document.status().to_string();
  EXPECT_EQ(*read_indices(*document, 2), sequence);
  const auto n = read_values(*document, 3)->data;
  for (std::size_t i = 0; i < 2; ++i) {
    // 8-bit octahedral code: about a degree.
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(n[3 * i + c], normals[4 * i + c], 0.02f);
  }
  const auto q = read_values(*document, 4)->data;
  for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(q[c], turn[c], 1e-3f);
  const auto f = read_values(*document, 5)->data;
  // 20 bits of mantissa shared by the vector: relative to its largest component.
  for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(f[c], floats[c], 1000 * 0x1p-18f);
}

TEST(Meshopt, FaultsAreRefused) {
  const auto refused = [](std::size_t view, const char* name, const Json& value) {
    CompressedSquare square;
    square.extension(view)[name] = value;
    const auto document = square.builder.read();
    return !document.ok() && document.status().reason() == "INPUT_MALFORMED" &&
           document.status().place().find("/bufferViews/") != std::string::npos;
  };
  EXPECT_TRUE(refused(0, "buffer", 7));
  EXPECT_TRUE(refused(0, "buffer", 1));  // the fallback buffer has no bytes
  EXPECT_TRUE(refused(0, "byteOffset", 1 << 20));
  EXPECT_TRUE(refused(0, "byteLength", 1 << 20));
  EXPECT_TRUE(refused(0, "byteLength", 0));
  EXPECT_TRUE(refused(0, "byteStride", 0));
  EXPECT_TRUE(refused(0, "byteStride", 6));
  EXPECT_TRUE(refused(0, "byteStride", 260));
  EXPECT_TRUE(refused(0, "count", 5));
  EXPECT_TRUE(refused(0, "count", 9007199254740991));
  EXPECT_TRUE(refused(0, "mode", "SOMETHING"));
  EXPECT_TRUE(refused(0, "filter", "SOMETHING"));
  EXPECT_TRUE(refused(0, "filter", "QUATERNION"));   // needs a stride of 8
  EXPECT_TRUE(refused(0, "filter", "OCTAHEDRAL"));   // needs a stride of 4 or 8
  EXPECT_TRUE(refused(1, "filter", "EXPONENTIAL"));  // not for indices
  EXPECT_TRUE(refused(1, "mode", "ATTRIBUTES"));
  EXPECT_TRUE(refused(1, "byteStride", 3));
}

TEST(Meshopt, ShortDataCannotClaimMuch) {
  CompressedSquare square;
  square.extension(0)["count"] = 1'000'000;
  square.builder.json["bufferViews"][0]["byteLength"] = 12'000'000;
  square.builder.json["buffers"][1]["byteLength"] = 16'000'000;
  const auto document = square.builder.read();
  ASSERT_FALSE(document.ok());
  EXPECT_NE(document.status().message().find("cannot hold"), std::string::npos)
      << document.status().to_string();
}

TEST(Meshopt, TruncatedAndDamagedDataNeverCrash) {
  CompressedSquare square;
  for (std::size_t view = 0; view < 2; ++view) {
    const std::size_t length = square.extension(view)["byteLength"];
    const std::size_t offset = square.extension(view)["byteOffset"];
    for (std::size_t size = 1; size < length; ++size) {
      CompressedSquare cut;
      cut.extension(view)["byteLength"] = size;
      EXPECT_FALSE(cut.builder.read().ok()) << view << " " << size;
    }
    for (std::size_t i = 0; i < length; ++i) {
      for (const auto flip : {std::byte{1}, std::byte{0x80}, std::byte{0xff}}) {
        CompressedSquare damaged;
        damaged.builder.binary[offset + i] ^= flip;
        const auto document = damaged.builder.read();
        if (document.ok()) {
          EXPECT_EQ(read_indices(*document, 1)->size(), 6u);
        }
      }
    }
  }
}

}  // namespace
}  // namespace lightbatch::gltf
