#include <gtest/gtest.h>

#include "core/gltf/glb_container.h"
#include "tests/unit/gltf/scene_files.h"

namespace lightbatch::gltf {
namespace {

Bytes square_glb() {
  SceneBuilder builder;
  builder.square();
  return builder.glb();
}

void put_u32(Bytes& bytes, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::byte>(value >> (8 * i));
}

TEST(Glb, RoundTrips) {
  const Bytes bytes = square_glb();
  SceneFiles files;
  files.add("a/scene.glb", bytes);
  const auto document = files.read("a/scene.glb");
  ASSERT_TRUE(document.ok()) << document.status().to_string();
  EXPECT_EQ(document->buffers.size(), 1u);
  EXPECT_EQ(document->input_bytes, bytes.size());
  EXPECT_EQ(document->sha256.size(), 64u);
  EXPECT_TRUE(document->warnings.empty()) << document->warnings[0];
  const auto again = write_glb(document->json, document->buffers[0]);
  ASSERT_TRUE(again.ok());
  // The buffer's bytes may carry padding that the length in the JSON then counts.
  EXPECT_EQ(again->size(), bytes.size());
  EXPECT_EQ(*write_glb(document->json, document->buffers[0]), *again);
}

TEST(Glb, EveryTruncationIsRefused) {
  const Bytes bytes = square_glb();
  SceneFiles files;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto chunks = split_glb(std::span(bytes).first(size), "cut.glb");
    EXPECT_FALSE(chunks.ok()) << size;
    // With the length mended, the chunks themselves must be found short.
    Bytes mended(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    if (size < 12) continue;
    put_u32(mended, 8, static_cast<std::uint32_t>(size));
    files.add("cut.glb", mended);
    EXPECT_FALSE(files.read("cut.glb").ok()) << size;
  }
}

TEST(Glb, EveryByteMayBeDamaged) {
  const Bytes bytes = square_glb();
  SceneFiles files;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (const auto flip : {std::byte{0x01}, std::byte{0x80}, std::byte{0xff}}) {
      Bytes damaged = bytes;
      damaged[i] ^= flip;
      files.add("damaged.glb", damaged);
      const auto document = files.read("damaged.glb");
      if (!document.ok()) {
        EXPECT_FALSE(document.status().place().empty());
        EXPECT_FALSE(document.status().message().empty());
      }
    }
  }
}

TEST(Glb, HeadersThatLieAreRefused) {
  const Bytes good = square_glb();
  const auto refused = [&good](std::size_t at, std::uint32_t value) {
    Bytes bytes = good;
    put_u32(bytes, at, value);
    return split_glb(bytes, "x.glb").status().reason();
  };
  EXPECT_EQ(refused(4, 0), "INPUT_MALFORMED");
  EXPECT_EQ(refused(4, 1), "INPUT_UNSUPPORTED");
  EXPECT_EQ(refused(4, 3), "INPUT_UNSUPPORTED");
  EXPECT_EQ(refused(8, 0xffffffffu), "INPUT_MALFORMED");
  EXPECT_EQ(refused(8, 0), "INPUT_MALFORMED");
  EXPECT_EQ(refused(12, 0xffffffffu), "INPUT_MALFORMED");
  EXPECT_EQ(refused(12, 0xfffffffcu), "INPUT_MALFORMED");
  EXPECT_EQ(refused(12, 3), "INPUT_MALFORMED");
  EXPECT_EQ(refused(16, 0x004e4942), "INPUT_MALFORMED");
  EXPECT_EQ(refused(12, 0), "INPUT_MALFORMED");  // what follows is no chunk header
}

TEST(Glb, SecondChunksAreRefusedAndUnknownOnesSkipped) {
  const auto chunk = [](std::string_view type, std::string_view data) {
    std::string text(4, '\0');
    text[0] = static_cast<char>(data.size());
    return text + std::string(type) + std::string(data);
  };
  const auto file = [](const std::string& chunks) {
    std::string text = std::string("glTF\2\0\0\0\0\0\0\0", 12) + chunks;
    text[8] = static_cast<char>(text.size());
    return text;
  };
  const std::string json = chunk("JSON", "{}  ");
  const std::string binary = chunk(std::string_view("BIN\0", 4), "1234");
  const std::string other = chunk("XYZ1", "5678");
  EXPECT_TRUE(split_glb(as_bytes(file(json + binary + other + other)), "x").ok());
  EXPECT_TRUE(split_glb(as_bytes(file(json + other)), "x").ok());
  EXPECT_FALSE(split_glb(as_bytes(file(json + binary + binary)), "x").ok());
  EXPECT_FALSE(split_glb(as_bytes(file(json + json)), "x").ok());
  EXPECT_FALSE(split_glb(as_bytes(file(json + other + binary)), "x").ok());
  EXPECT_FALSE(split_glb(as_bytes(file(binary + json)), "x").ok());
  EXPECT_FALSE(split_glb(as_bytes(file("")), "x").ok());
}

TEST(Glb, OtherFilesAreNamed) {
  SceneFiles files;
  files.add("page.glb", "<html></html>");
  files.add("mesh.drc", std::string_view("DRACO\2\2\1\1\0\0", 11));
  files.add("empty.glb", "");
  files.add("array.gltf", "[]");
  EXPECT_EQ(files.read("page.glb").status().reason(), "INPUT_MALFORMED");
  EXPECT_EQ(files.read("mesh.drc").status().reason(), "INPUT_UNSUPPORTED");
  EXPECT_EQ(files.read("empty.glb").status().place(), "empty.glb@0");
  EXPECT_EQ(files.read("array.gltf").status().reason(), "INPUT_MALFORMED");
  EXPECT_EQ(files.read("absent.glb").status().reason(), "SCENE_URI_FORBIDDEN");
}

TEST(WriteGlb, WritesNoChunkForNoBytesAndRefusesBadNumbers) {
  const auto bytes = write_glb({{"asset", {{"version", "2.0"}}}}, {});
  ASSERT_TRUE(bytes.ok());
  EXPECT_FALSE(split_glb(*bytes, "x")->binary.has_value());
  EXPECT_FALSE(write_glb({{"asset", {{"x", std::nan("")}}}}, {}).ok());
}

}  // namespace
}  // namespace lightbatch::gltf
