#include "core/math/rgb.h"

#include <gtest/gtest.h>

#include <limits>

namespace lightbatch {
namespace {

TEST(Rgb, LuminanceOfWhiteIsOne) {
  EXPECT_NEAR(luminance(Rgbd{1, 1, 1}), 1, 1e-15);
  EXPECT_EQ(luminance(Rgbd{0, 1, 0}), 0.7152);
}

TEST(Rgb, Arithmetic) {
  Rgbd sum{1, 2, 3};
  sum += Rgbd{1, 1, 1} * 2.0;
  sum *= Rgbd{2, 1, 0.5};
  EXPECT_EQ(sum, (Rgbd{6, 4, 2.5}));
  EXPECT_EQ(sum.max(), 6);
  EXPECT_EQ(sum.sum(), 12.5);
  EXPECT_FALSE(sum.is_black());
  EXPECT_TRUE(Rgbd().is_black());
  EXPECT_EQ(Rgb::grey(0.5f), (Rgb{0.5f, 0.5f, 0.5f}));
}

TEST(Rgb, FindsWhatIsNotFinite) {
  EXPECT_TRUE(is_finite(Rgb{1, 2, 3}));
  EXPECT_FALSE(is_finite(Rgb{1, std::numeric_limits<float>::quiet_NaN(), 3}));
  EXPECT_FALSE(is_finite(Rgb{1, 2, std::numeric_limits<float>::infinity()}));
}

TEST(Srgb, KnownValues) {
  EXPECT_EQ(srgb_to_linear(0), 0);
  EXPECT_NEAR(srgb_to_linear(1), 1, 1e-6);
  EXPECT_NEAR(srgb_to_linear(0.5f), 0.21404114, 1e-6);  // IEC 61966-2-1
  EXPECT_NEAR(linear_to_srgb(0.18f), 0.46135613, 1e-6);
  // The two pieces meet.
  EXPECT_NEAR(srgb_to_linear(0.04045f), srgb_to_linear(0.040451f), 1e-6);
}

TEST(Srgb, EachByteComesBack) {
  for (int byte = 0; byte < 256; ++byte) {
    const float linear = srgb_to_linear(static_cast<float>(byte) / 255);
    EXPECT_EQ(std::lround(linear_to_srgb(linear) * 255), byte);
  }
}

}  // namespace
}  // namespace lightbatch
