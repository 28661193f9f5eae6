#include "core/math/aabb.h"

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace lightbatch {
namespace {

TEST(Aabb, StartsEmpty) {
  const Aabb box;
  EXPECT_TRUE(box.is_empty());
  EXPECT_EQ(box.extent(), (Vec3f{}));
  EXPECT_EQ(box.area(), 0);
  EXPECT_EQ(box.diagonal(), 0);
  EXPECT_FALSE(box.contains({0, 0, 0}));
  EXPECT_FALSE(box.overlaps(Aabb{{-1, -1, -1}, {1, 1, 1}}));
}

TEST(Aabb, EmptyIsNeutralInUnions) {
  Aabb box{{1, 2, 3}, {4, 5, 6}};
  box.add(Aabb());
  EXPECT_EQ(box, (Aabb{{1, 2, 3}, {4, 5, 6}}));
  Aabb empty;
  empty.add(box);
  EXPECT_EQ(empty, box);
}

TEST(Aabb, IsTheTightestBoxOfItsPoints) {
  Random random(1);
  Aabbd box;
  std::vector<Vec3d> points;
  for (int i = 0; i < 100; ++i) {
    points.push_back({random.next_double(), random.next_double() - 5, random.next_double() * 3});
    box.add(points.back());
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double least = points[0][axis], most = points[0][axis];
    for (const Vec3d& p : points) {
      EXPECT_TRUE(box.contains(p));
      least = std::min(least, p[axis]);
      most = std::max(most, p[axis]);
    }
    EXPECT_EQ(box.lower[axis], least);
    EXPECT_EQ(box.upper[axis], most);
  }
}

TEST(Aabb, AreaCentreAndDiagonal) {
  const Aabbd box{{0, 0, 0}, {2, 3, 6}};
  EXPECT_EQ(box.area(), 2 * (6 + 18 + 12));
  EXPECT_EQ(box.centre(), (Vec3d{1, 1.5, 3}));
  EXPECT_EQ(box.diagonal(), 7);
  const Aabbd flat{{0, 0, 0}, {2, 0, 3}};
  EXPECT_EQ(flat.area(), 12) << "both sides of a flat box";
  EXPECT_FALSE(flat.is_empty());
}

TEST(Aabb, TouchingBoxesOverlap) {
  const Aabb a{{0, 0, 0}, {1, 1, 1}};
  EXPECT_TRUE(a.overlaps({{1, 0, 0}, {2, 1, 1}}));
  EXPECT_FALSE(a.overlaps({{1.001f, 0, 0}, {2, 1, 1}}));
  EXPECT_FALSE(a.overlaps({{0, 0, -2}, {1, 1, -0.1f}}));
}

}  // namespace
}  // namespace lightbatch
