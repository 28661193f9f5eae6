#include "core/image/codecs.h"

#include <gtest/gtest.h>

namespace lightbatch::image {
namespace {

Image8 test_image(int width, int height) {
  Image8 image;
  image.width = width;
  image.height = height;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (const int value : {x * 7 + y, x * y, 255 - x, 128 + y}) {
        image.rgba.push_back(static_cast<std::uint8_t>(value));
      }
    }
  }
  return image;
}

TEST(Png, RoundTripsEveryPixel) {
  const Image8 image = test_image(37, 19);
  const Bytes bytes = encode_png(image, true);
  EXPECT_EQ(detect_format(bytes), Format::kPng);
  const auto decoded = decode_image8(bytes, "test.png");
  ASSERT_TRUE(decoded.ok()) << decoded.status().to_string();
  EXPECT_EQ(decoded->width, 37);
  EXPECT_EQ(decoded->height, 19);
  EXPECT_EQ(decoded->rgba, image.rgba);
}

}  // namespace
}  // namespace lightbatch::image
