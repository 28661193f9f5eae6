#include "core/optics/surface_frame.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lightbatch::optics {
namespace {

scene::Scene triangle_of(float size, const Vec3f& at) {
  scene::Scene scene;
  scene.positions = {at, at + Vec3f{size, 0, 0}, at + Vec3f{0, 0, -size}};
  scene::Triangle t;
  t.vertex = {0, 1, 2};
  scene.triangles.push_back(t);
  return scene;
}

TEST(SurfaceFrame, LiftFollowsTheTriangleAndTheScene) {
  const float far = kRoundingOfMix * 1e5f, near = kRoundingOfMix * 10;  // of 100 km and of 10 m
  const auto lifted = [](const scene::Scene& scene, float lift) {
    const SurfaceFrame frame = surface_frame(scene, 0, 0.25f, 0.25f, false, lift);
    return length(frame.origin - frame.position);
  };
  // The rounding of the scene, where triangles are not tiny against it.
  EXPECT_FLOAT_EQ(lifted(triangle_of(0.1f, {0, 0, 0}), near), near);
  EXPECT_NEAR(lifted(triangle_of(1000, {0, 0, 0}), far), far, 1e-3f * far);
  // A housing of 4 cm, and a triangle of a millimetre far out: its own rounding.
  EXPECT_NEAR(lifted(triangle_of(0.04f, {0, 0, 0}), far), 4e-5f, 1e-6f);
  EXPECT_NEAR(lifted(triangle_of(1e-3f, {8, 0, 0}), near), 8e-6f, 1e-6f);
  EXPECT_EQ(lifted(triangle_of(1, {0, 0, 0}), 0), 0);
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
