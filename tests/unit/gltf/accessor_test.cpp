#include "core/gltf/accessor.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/gltf/scene_files.h"

namespace lightbatch::gltf {
namespace {

std::vector<float> values_of(const Document& document, std::size_t accessor) {
  const auto values = read_values(document, static_cast<std::uint32_t>(accessor));
  EXPECT_TRUE(values.ok()) << values.status().to_string();
  return values.ok() ? values->data : std::vector<float>{};
}

TEST(Accessor, NormalisedIntegersMapAsTheSpecificationSays) {
  SceneBuilder builder;
  builder.square();
  const std::size_t i8 =
      builder.accessor(std::vector<std::int8_t>{-128, -127, 0, 127}, "SCALAR", 1);
  const std::size_t u8 = builder.accessor(std::vector<std::uint8_t>{0, 51, 255, 1}, "SCALAR", 1);
  const std::size_t i16 =
      builder.accessor(std::vector<std::int16_t>{-32768, -32767, 32767, 0}, "SCALAR", 1);
  const std::size_t u16 = builder.accessor(std::vector<std::uint16_t>{0, 65535}, "SCALAR", 1);
  const std::size_t plain = builder.accessor(std::vector<std::int16_t>{-5, 300}, "SCALAR", 1);
  for (const std::size_t a : {i8, u8, i16, u16}) builder.json["accessors"][a]["normalized"] = true;
  const auto document = builder.read();
  ASSERT_TRUE(document.ok()) << document.status().to_string();
  EXPECT_EQ(values_of(*document, i8), (std::vector<float>{-1, -1, 0, 1}));
  EXPECT_EQ(values_of(*document, u8), (std::vector<float>{0, 0.2f, 1, 1.0f / 255}));
  EXPECT_EQ(values_of(*document, i16), (std::vector<float>{-1, -1, 1, 0}));
  EXPECT_EQ(values_of(*document, u16), (std::vector<float>{0, 1}));
  EXPECT_EQ(values_of(*document, plain), (std::vector<float>{-5, 300}));
}

TEST(Accessor, StridedViewsAndSomeElements) {
  SceneBuilder builder;
  builder.square();
  const std::size_t a = builder.accessor(std::vector<float>{1, 2, 9, 3, 4, 9, 5, 6, 9}, "VEC2", 2);
  const std::size_t view = builder.json["accessors"][a]["bufferView"];
  builder.json["bufferViews"][view]["byteStride"] = 12;
  builder.json["accessors"][a]["count"] = 3;
  const auto document = builder.read();
  ASSERT_TRUE(document.ok()) << document.status().to_string();
  EXPECT_EQ(values_of(*document, a), (std::vector<float>{1, 2, 3, 4, 5, 6}));
  const std::uint32_t wanted[] = {2, 0};
  EXPECT_EQ(read_elements(*document, static_cast<std::uint32_t>(a), wanted)->data,
            (std::vector<float>{5, 6, 1, 2}));
  const auto packed = read_packed(*document, static_cast<std::uint32_t>(a));
  ASSERT_TRUE(packed.ok());
  EXPECT_EQ(packed->size(), 24u);
}

/// A sparse accessor over `base` (or zeros): elements 1 and 3 of 4 become 7 and 8.
Json sparse_accessor(SceneBuilder& builder, bool base) {
  Json accessor = {{"componentType", 5126}, {"count", 4}, {"type", "SCALAR"}};
  if (base) accessor["bufferView"] = builder.view(std::vector<float>{1, 2, 3, 4});
  accessor["sparse"] = {
      {"count", 2},
      {"indices",
       {{"bufferView", builder.view(std::vector<std::uint8_t>{1, 3})}, {"componentType", 5121}}},
      {"values", {{"bufferView", builder.view(std::vector<float>{7, 8})}}}};
  return accessor;
}

TEST(Accessor, SparseValuesReplace) {
  for (const bool base : {true, false}) {
    SceneBuilder builder;
    builder.square();
    builder.json["accessors"].push_back(sparse_accessor(builder, base));
    const std::size_t a = builder.json["accessors"].size() - 1;
    const auto document = builder.read();
    ASSERT_TRUE(document.ok()) << document.status().to_string();
    const std::vector<float> expected =
        base ? std::vector<float>{1, 7, 3, 8} : std::vector<float>{0, 7, 0, 8};
    EXPECT_EQ(values_of(*document, a), expected);
    const std::uint32_t wanted[] = {3, 2, 1};
    EXPECT_EQ(read_elements(*document, static_cast<std::uint32_t>(a), wanted)->data,
              (std::vector<float>{expected[3], expected[2], expected[1]}));
    const auto packed = read_packed(*document, static_cast<std::uint32_t>(a));
    ASSERT_TRUE(packed.ok());
    EXPECT_EQ(std::memcmp(packed->data(), expected.data(), 16), 0);
  }
}

TEST(Accessor, SmallMatricesHavePaddedColumns) {
  SceneBuilder builder;
  builder.square();
  // MAT2 of bytes: each column of 2 bytes is padded to 4.
  const std::size_t view = builder.view(std::vector<std::uint8_t>{1, 2, 0, 0, 3, 4, 0, 0});
  builder.json["accessors"].push_back(
      {{"bufferView", view}, {"componentType", 5121}, {"count", 1}, {"type", "MAT2"}});
  const auto document = builder.read();
  ASSERT_TRUE(document.ok()) << document.status().to_string();
  EXPECT_EQ(values_of(*document, 2), (std::vector<float>{1, 2, 3, 4}));
}

TEST(Accessor, ValuesThatAreNotFiniteAreNamed) {
  SceneBuilder builder;
  builder.square();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::size_t a = builder.accessor(std::vector<float>{1, 2, nan, 4}, "VEC2", 2);
  const auto document = builder.read();
  ASSERT_FALSE(document.ok());
  EXPECT_EQ(document.status().place(), "scene.glb#/accessors/" + std::to_string(a));
}

TEST(Accessor, BoundsAreHeldAgainstTheData) {
  SceneBuilder builder;
  builder.square();
  const std::vector<float> values = {0.1f, 5, -2, 7};
  const std::size_t a = builder.accessor(values, "VEC2", 2);
  builder.bound(a, values, 2);
  EXPECT_TRUE(builder.read()->warnings.empty());
  builder.json["accessors"][a]["min"] = {-2.5, 5};
  auto document = builder.read();
  ASSERT_TRUE(document.ok());
  ASSERT_EQ(document->warnings.size(), 1u);
  EXPECT_NE(document->warnings[0].find("/accessors/2/min"), std::string::npos);
  builder.json["accessors"][a]["min"] = {-2};
  EXPECT_EQ(builder.read().status().place(), "scene.glb#/accessors/2/min");
}

TEST(Accessor, IndicesOfEveryWidth) {
  SceneBuilder builder;
  builder.square();
  const std::size_t u8 = builder.accessor(std::vector<std::uint8_t>{0, 255, 3}, "SCALAR", 1);
  const std::size_t u32 =
      builder.accessor(std::vector<std::uint32_t>{0, 4'000'000'000u}, "SCALAR", 1);
  const auto document = builder.read();
  ASSERT_TRUE(document.ok());
  EXPECT_EQ(*read_indices(*document, static_cast<std::uint32_t>(u8)),
            (std::vector<std::uint32_t>{0, 255, 3}));
  EXPECT_EQ(*read_indices(*document, static_cast<std::uint32_t>(u32)),
            (std::vector<std::uint32_t>{0, 4'000'000'000u}));
  EXPECT_FALSE(read_indices(*document, 0).ok());
}

}  // namespace
}  // namespace lightbatch::gltf
