#include "core/optics/surface_frame.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lightbatch::optics {
namespace {

TEST(SurfaceFrame, LiftFollowsThePlaceAndTheScene) {
  const float lift = kRoundingOfMix * 1e5f;  // a ground of 100 km
  // At the far end of the scene: its rounding.
  EXPECT_FLOAT_EQ(lift_near(1e5f, lift), lift);
  // A centimetre from the middle: far less than a housing of a centimetre, more than its rounding.
  EXPECT_LT(lift_near(0.01f, lift), 1e-4f);
  EXPECT_GT(lift_near(0.01f, lift), 16 * (std::nextafter(0.01f, 1.0f) - 0.01f));
  EXPECT_EQ(lift_near(0, lift), 0);
  EXPECT_EQ(lift_near(1, 0), 0);
}

TEST(SurfaceFrame, ShadowRaysEndBeforeThePlaneOfTheLamp) {
  const float lift = kRoundingOfMix * 1e5f;
  const Vec3f lamp{0.02f, 0.01f, 0};
  const Vec3f from{3, 2, 1};
  const Vec3f to = lamp - from;
  const float end = shadow_end(to, lamp, lift);
  EXPECT_LT(end, 1);
  EXPECT_LT((1 - end) * length(to), 1e-4f);
  // Nearer than the lift there is nothing between.
  EXPECT_EQ(shadow_end({1e-9f, 0, 0}, lamp, lift), 0);
}

}  // namespace
}  // namespace lightbatch::optics
