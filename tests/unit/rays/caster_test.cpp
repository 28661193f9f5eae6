#include "core/rays/caster.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/unit/rays/oracle.h"

namespace lightbatch::rays {
namespace {

using testing::Mesh;
using testing::Oracle;
using testing::OracleHit;
using testing::soup;

// Barycentric distance below which float inputs leave the double oracle itself in doubt:
// a few hundred roundings of 2^-53.
constexpr double kDoubt = 1e-12;

/// Furniture of axis-parallel squares: flat boxes, coplanar neighbours, shared edges.
Mesh axis_parallel(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  Mesh mesh;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t axis = random.below(3);
    Vec3f at{static_cast<float>(random.below(8)), static_cast<float>(random.below(8)),
             static_cast<float>(random.below(8))};
    Vec3f s, t;
    s[(axis + 1) % 3] = 1;
    t[(axis + 2) % 3] = 1;
    mesh.add(at, at + s, at + s + t);
    mesh.add(at, at + s + t, at + t);
  }
  return mesh;
}

void compare_to_oracle(const Mesh& mesh, std::span<const Ray> rays) {
  const Caster caster = mesh.caster();
  std::size_t doubtful = 0;
  for (const Ray& ray : rays) {
    double margin = 1;
    const OracleHit expected = Oracle::closest(mesh, ray, kNoTriangle, margin);
    const Hit hit = caster.closest(ray);
    ASSERT_EQ(caster.occluded(ray), hit.found());
    if (margin < kDoubt) {
      ++doubtful;
      continue;
    }
    ASSERT_EQ(hit.found(), expected.triangle != kNoTriangle);
    if (!hit.found()) continue;
    // t is a double rounded to float: half a unit in the last place, and the oracle's own noise.
    ASSERT_NEAR(static_cast<double>(hit.t), expected.t, 1e-7 * std::abs(expected.t) + 1e-12);
    OracleHit same;
    ASSERT_TRUE(Oracle::test(mesh, hit.triangle, ray, same, margin));
    ASSERT_LE(same.t, expected.t + 1e-7 * std::abs(expected.t));
    ASSERT_NEAR(static_cast<double>(hit.u), same.u, 1e-6);
    ASSERT_NEAR(static_cast<double>(hit.v), same.v, 1e-6);
  }
  EXPECT_LT(doubtful, rays.size() / 2);
}

TEST(Caster, EmptyAndSingle) {
  const Mesh empty;
  EXPECT_FALSE(empty.caster().closest({{0, 0, 0}, {0, 0, 1}}).found());
  EXPECT_FALSE(empty.caster().occluded({{0, 0, 0}, {0, 0, 1}}));
  Mesh one;
  one.add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const Caster caster = one.caster();
  const Hit front = caster.closest({{0.25f, 0.5f, 2}, {0, 0, -4}});
  ASSERT_TRUE(front.found());
  EXPECT_EQ(front.t, 0.5f);
  EXPECT_EQ(front.u, 0.25f);
  EXPECT_EQ(front.v, 0.5f);
  EXPECT_FALSE(front.back);
  EXPECT_TRUE(caster.closest({{0.25f, 0.5f, -2}, {0, 0, 1}}).back);
  EXPECT_FALSE(caster.closest({{0.25f, 0.5f, 2}, {0, 0, -4}}, 0).found());
  EXPECT_FALSE(caster.occluded({{0.25f, 0.5f, 2}, {0, 0, -4}}, kNoTriangle, 0));
}

TEST(Caster, RangeIsOpenAtBothEnds) {
  Mesh one;
  one.add({-1, -1, 1}, {1, -1, 1}, {0, 1, 1});
  const Caster caster = one.caster();
  EXPECT_FALSE(caster.occluded({{0, 0, 0}, {0, 0, 1}, 0, 1}));
  EXPECT_FALSE(caster.occluded({{0, 0, 0}, {0, 0, 1}, 1, 2}));
  EXPECT_TRUE(caster.occluded({{0, 0, 0}, {0, 0, 1}, 0, std::nextafter(1.0f, 2.0f)}));
  EXPECT_TRUE(caster.occluded({{0, 0, 0}, {0, 0, 1}, std::nextafter(1.0f, 0.0f), 2}));
  EXPECT_FALSE(caster.occluded({{0, 0, 1}, {0, 0, 1}}));
}

TEST(Caster, EqualDistanceGoesToTheLowerIndex) {
  Mesh mesh;
  for (int i = 0; i < 20; ++i) mesh.add({-1, -1, 1}, {1, -1, 1}, {0, 1, 1});
  const Caster caster = mesh.caster();
  EXPECT_EQ(caster.closest({{0, 0, 0}, {0, 0, 1}}).triangle, 0u);
  EXPECT_EQ(caster.closest({{0, 0, 0}, {0, 0, 1}}, 0).triangle, 1u);
}

TEST(Caster, NonsenseRaysHitNothing) {
  const Caster caster = soup(50, 0.5f, 1).caster();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  for (const Ray& ray :
       {Ray{{0, 0, 0}, {0, 0, 0}}, Ray{{nan, 0, 0}, {1, 0, 0}}, Ray{{0, 0, 0}, {nan, 0, 1}},
        Ray{{inf, 0, 0}, {-1, 0, 0}}, Ray{{0, 0, 0}, {inf, 0, 0}},
        Ray{{.5f, .5f, .5f}, {1, 1, 1}, 1, 0}, Ray{{.5f, .5f, .5f}, {1, 1, 1}, nan, nan}}) {
    EXPECT_FALSE(caster.closest(ray).found());
    EXPECT_FALSE(caster.occluded(ray));
  }
}

TEST(Caster, MatchesTheOracleOnRandomTriangles) {
  Random random(11);
  for (const float size : {0.02f, 0.3f, 5.0f}) {
    const Mesh mesh = soup(400, size, 5);
    std::vector<Ray> rays;
    for (int i = 0; i < 3000; ++i) {
      Ray ray{testing::random_point(random) * 3.0f - Vec3f{1, 1, 1}, {}};
      ray.direction = (testing::random_point(random) - ray.origin) * (i % 2 == 0 ? 1.0f : 1e-3f);
      if (i % 3 == 0) ray.t_max = 1;
      rays.push_back(ray);
    }
    compare_to_oracle(mesh, rays);
  }
}

TEST(Caster, MatchesTheOracleOnAxisParallelScenes) {
  Random random(12);
  const Mesh mesh = axis_parallel(300, 9);
  std::vector<Ray> rays;
  for (int i = 0; i < 6000; ++i) {
    Ray ray{testing::random_point(random) * 9.0f, testing::random_direction(random)};
    if (i % 2 == 0) {  // along an axis
      ray.direction = {};
      ray.direction[random.below(3)] = i % 4 == 0 ? 1.0f : -1.0f;
    }
    rays.push_back(ray);
  }
  compare_to_oracle(mesh, rays);
}

TEST(Caster, MatchesTheOracleOnExtremeScales) {
  Random random(13);
  for (const float scale : {1e-15f, 1e-4f, 1e6f, 1e15f}) {
    Mesh mesh = soup(200, 0.4f, 21);
    for (Vec3f& p : mesh.positions) p = p * scale;
    std::vector<Ray> rays;
    for (int i = 0; i < 1000; ++i) {
      rays.push_back({testing::random_point(random) * scale, testing::random_direction(random)});
    }
    compare_to_oracle(mesh, rays);
  }
}

/// Rays from inside a closed mesh, aimed at vertices and edge midpoints, must not get out.
TEST(Caster, NoLeaksAtVerticesAndEdges) {
  constexpr int kRings = 60, kSides = 40;
  Mesh mesh;
  Random random(5);
  for (int i = 0; i < kRings; ++i) {
    for (int j = 0; j < kSides; ++j) {
      const double a = 2 * 3.141592653589793 * i / kRings, b = 2 * 3.141592653589793 * j / kSides;
      const double r = 0.35 + 0.1 * random.next_double();
      mesh.positions.push_back(to_float(Vec3d{(1 + r * std::cos(b)) * std::cos(a), r * std::sin(b),
                                              (1 + r * std::cos(b)) * std::sin(a)}));
    }
  }
  const auto index = [](int i, int j) {
    return static_cast<std::uint32_t>((i % kRings) * kSides + j % kSides);
  };
  for (int i = 0; i < kRings; ++i) {
    for (int j = 0; j < kSides; ++j) {
      mesh.triangles.push_back({index(i, j), index(i, j + 1), index(i + 1, j)});
      mesh.triangles.push_back({index(i + 1, j), index(i, j + 1), index(i + 1, j + 1)});
    }
  }
  const Caster caster = mesh.caster();
  std::size_t leaks = 0;
  for (int i = 0; i < 100000; ++i) {
    const double a = 2 * 3.141592653589793 * random.next_double();
    const Vec3f origin = to_float(Vec3d{std::cos(a), 0.0, std::sin(a)});
    const auto& triangle = mesh.triangles[random.below(mesh.triangles.size())];
    const Vec3f p = mesh.positions[triangle[0]];
    const Vec3f target = i % 2 == 0 ? p : (p + mesh.positions[triangle[1]]) * 0.5f;
    leaks += !caster.closest({origin, target - origin}).found();
  }
  EXPECT_EQ(leaks, 0u);
}

}  // namespace
}  // namespace lightbatch::rays
