#include <gtest/gtest.h>

#include <string>

#include "core/image/codecs.h"

namespace lightbatch::image {
namespace {

const std::string kHead = "#?RADIANCE\nSOFTWARE=test\nFORMAT=32-bit_rle_rgbe\n\n";

std::string pixel(int r, int g, int b, int e) {
  return {static_cast<char>(r), static_cast<char>(g), static_cast<char>(b), static_cast<char>(e)};
}

TEST(Hdr, FlatPixelsHaveTheValueOfTheirExponent) {
  // m / 256 * 2^(e - 128): 128 at exponent 129 is 1, 64 is a half; exponent 0 is black.
  const std::string file = kHead + "-Y 2 +X 2\n" + pixel(128, 64, 32, 129) + pixel(9, 9, 9, 0) +
                           pixel(128, 0, 0, 138) + pixel(0, 0, 128, 119);
  const auto image = decode_image_rgb(as_bytes(file), "sky.hdr");
  ASSERT_TRUE(image.ok()) << image.status().to_string();
  EXPECT_EQ(image->at(0, 0), (Rgb{1.0f, 0.5f, 0.25f}));
  EXPECT_EQ(image->at(1, 0), (Rgb{0, 0, 0}));
  EXPECT_EQ(image->at(0, 1), (Rgb{512.0f, 0, 0}));
  EXPECT_EQ(image->at(1, 1), (Rgb{0, 0, 0x1p-10f}));
}

TEST(Hdr, ExposureDividesAndOrientationFlips) {
  const std::string file = "#?RGBE\nEXPOSURE=2\nFORMAT=32-bit_rle_rgbe\n\n+Y 2 -X 1\n" +
                           pixel(128, 128, 128, 129) + pixel(128, 128, 128, 130);
  const auto image = decode_image_rgb(as_bytes(file), "sky.hdr");
  ASSERT_TRUE(image.ok()) << image.status().to_string();
  EXPECT_EQ(image->at(0, 0).r, 1.0f);  // stored last: the bottom-up order puts it on top
  EXPECT_EQ(image->at(0, 1).r, 0.5f);
}

TEST(Hdr, RunLengthsByComponent) {
  std::string row = pixel(2, 2, 0, 8);
  for (int c = 0; c < 4; ++c) {
    row += static_cast<char>(128 + 5);  // five times the same
    row += static_cast<char>(c == 3 ? 129 : 128);
    row += static_cast<char>(3);  // three literal values
    for (int i = 0; i < 3; ++i) row += static_cast<char>(c == 3 ? 129 : 64);
  }
  const auto image = decode_image_rgb(as_bytes(kHead + "-Y 1 +X 8\n" + row), "sky.hdr");
  ASSERT_TRUE(image.ok()) << image.status().to_string();
  EXPECT_EQ(image->at(4, 0), (Rgb{1, 1, 1}));
  EXPECT_EQ(image->at(5, 0), (Rgb{0.5f, 0.5f, 0.5f}));
}

TEST(Hdr, OldRunLengthsRepeatTheLastPixel) {
  const std::string row = pixel(128, 128, 128, 129) + pixel(1, 1, 1, 3) + pixel(64, 64, 64, 129);
  const auto image = decode_image_rgb(as_bytes(kHead + "-Y 1 +X 5\n" + row), "sky.hdr");
  ASSERT_TRUE(image.ok()) << image.status().to_string();
  EXPECT_EQ(image->at(3, 0).g, 1.0f);
  EXPECT_EQ(image->at(4, 0).g, 0.5f);
}

TEST(Hdr, BrokenFilesAreRefused) {
  const std::string row = pixel(128, 64, 32, 129);
  for (const std::string& file :
       {kHead, kHead + "-Y 1 +X 1", kHead + "-Y 1 +X 1\n", kHead + "-Y 2 +X 1\n" + row,
        kHead + "-Y 0 +X 1\n", kHead + "+X 1 -Y 1\n" + row, kHead + "-Y -1 +X 1\n" + row,
        kHead + "-Y 1 +X 2\n" + pixel(1, 1, 1, 2),              // a run with nothing before it
        kHead + "-Y 1 +X 3\n" + row + pixel(1, 1, 1, 200),      // a run past the row
        kHead + "-Y 1 +X 8\n" + pixel(2, 2, 0, 9) + row + row,  // another width
        kHead + "-Y 1 +X 8\n" + pixel(2, 2, 0, 8) + std::string(1, '\0'),
        std::string("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n") + row,
        std::string("#?RADIANCE\nEXPOSURE=nan\n\n-Y 1 +X 1\n") + row}) {
    EXPECT_FALSE(decode_image_rgb(as_bytes(file), "broken.hdr").ok()) << file;
  }
  const auto large = decode_image_rgb(as_bytes(kHead + "-Y 60000 +X 60000\n"), "bomb.hdr");
  EXPECT_EQ(large.status().reason(), "INPUT_OVER_BUDGET");
}

}  // namespace
}  // namespace lightbatch::image
