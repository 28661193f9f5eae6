#include "core/math/vec.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/base/random.h"

namespace lightbatch {
namespace {

Vec3d random_vector(Random& random) {
  return {2 * random.next_double() - 1, 2 * random.next_double() - 1, 2 * random.next_double() - 1};
}

TEST(Vec3, CrossIsRightHanded) {
  EXPECT_EQ(cross(Vec3d{1, 0, 0}, Vec3d{0, 1, 0}), (Vec3d{0, 0, 1}));
  EXPECT_EQ(cross(Vec3d{0, 1, 0}, Vec3d{0, 0, 1}), (Vec3d{1, 0, 0}));
}

TEST(Vec3, CrossIsPerpendicularAndLagrangeHolds) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const Vec3d a = random_vector(random), b = random_vector(random), c = cross(a, b);
    EXPECT_NEAR(dot(a, c), 0, 1e-15);
    EXPECT_NEAR(dot(b, c), 0, 1e-15);
    const double ab = dot(a, b);
    EXPECT_NEAR(dot(c, c) + ab * ab, dot(a, a) * dot(b, b), 1e-14);
  }
}

TEST(Vec3, NormalizedHasLengthOneAndZeroStaysZero) {
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_NEAR(length(normalized(random_vector(random) * 1e100)), 1, 1e-15);
  }
  EXPECT_EQ(normalized(Vec3d{}), (Vec3d{}));
  EXPECT_EQ(normalized(Vec3f{0, -2, 0}), (Vec3f{0, -1, 0}));
}

TEST(Vec3, IndexesItsComponents) {
  Vec3f v{1, 2, 3};
  v[1] = 5;
  EXPECT_EQ(v[0], 1);
  EXPECT_EQ(v.y, 5);
  EXPECT_EQ(v[2], 3);
}

TEST(Vec3, FindsWhatIsNotFinite) {
  const float inf = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(is_finite(Vec3f{1, 2, 3}));
  EXPECT_FALSE(is_finite(Vec3f{1, inf, 3}));
  EXPECT_FALSE(is_finite(Vec3f{1, 2, std::nanf("")}));
}

TEST(Vec2, CrossIsTwiceTheSignedArea) {
  EXPECT_EQ(cross(Vec2d{2, 0}, Vec2d{0, 3}), 6);
  EXPECT_EQ(cross(Vec2d{0, 3}, Vec2d{2, 0}), -6);
}

}  // namespace
}  // namespace lightbatch
