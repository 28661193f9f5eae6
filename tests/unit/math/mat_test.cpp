#include "core/math/mat.h"

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace lightbatch {
namespace {

double uniform(Random& random) { return 2 * random.next_double() - 1; }
Vec3d random_vector(Random& random) { return {uniform(random), uniform(random), uniform(random)}; }

Affine random_affine(Random& random) {
  return Affine::from_trs(random_vector(random) * 10,
                          {uniform(random), uniform(random), uniform(random), uniform(random)},
                          random_vector(random) * 2);
}

void expect_near(const Vec3d& a, const Vec3d& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(Affine, DefaultChangesNothing) {
  EXPECT_EQ(Affine().point({1, 2, 3}), (Vec3d{1, 2, 3}));
  EXPECT_EQ(Affine().determinant(), 1);
}

TEST(Affine, ProductAppliesTheRightOneFirst) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Affine a = random_affine(random), b = random_affine(random);
    const Vec3d p = random_vector(random);
    expect_near((a * b).point(p), a.point(b.point(p)), 1e-13);
    EXPECT_NEAR((a * b).determinant(), a.determinant() * b.determinant(), 1e-12);
  }
}

TEST(Affine, QuarterTurnAboutY) {
  const double half = std::sqrt(0.5);
  const Affine turn = Affine::from_trs({1, 0, 0}, {0, half, 0, half}, {1, 1, 1});
  expect_near(turn.point({1, 0, 0}), {1, 0, -1}, 1e-15);
  expect_near(turn.vector({0, 0, 1}), {1, 0, 0}, 1e-15);
}

TEST(Affine, QuaternionIsNormalisedAndZeroIsNoTurn) {
  const Affine twice = Affine::from_trs({}, {0, 2, 0, 2}, {1, 1, 1});
  expect_near(twice.vector({1, 0, 0}), {0, 0, -1}, 1e-15);
  EXPECT_EQ(Affine::from_trs({}, {0, 0, 0, 0}, {1, 1, 1}), Affine());
}

TEST(Affine, ColumnMajorMatrixOfGltf) {
  const Affine m = Affine::from_column_major({1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 10, 0, 11, 12, 13, 1});
  EXPECT_EQ(m.point({1, 0, 0}), (Vec3d{12, 14, 16}));
  EXPECT_EQ(m.vector({0, 1, 0}), (Vec3d{4, 5, 6}));
  EXPECT_EQ(m.determinant(), -3);
}

TEST(Affine, NormalStaysPerpendicularAndOnItsSideOfTheSurface) {
  Random random(2);
  int mirrored = 0;
  for (int i = 0; i < 500; ++i) {
    const Affine m = random_affine(random);
    const Vec3d a = random_vector(random), b = random_vector(random), n = cross(a, b);
    const Vec3d image = m.normal(n);
    const double scale = length(image) * std::max(length(m.vector(a)), length(m.vector(b)));
    EXPECT_NEAR(dot(image, m.vector(a)), 0, 1e-12 * scale + 1e-300);
    EXPECT_NEAR(dot(image, m.vector(b)), 0, 1e-12 * scale + 1e-300);
    EXPECT_GT(dot(image, m.vector(n)), 0) << "points to the other side";
    mirrored += m.determinant() < 0 ? 1 : 0;
  }
  EXPECT_GT(mirrored, 100);
}

}  // namespace
}  // namespace lightbatch
