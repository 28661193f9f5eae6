#include "core/rays/bundle.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/rays/kernel.h"
#include "tests/unit/rays/oracle.h"

namespace lightbatch::rays {
namespace {

using testing::Mesh;

Mesh soup(std::size_t n, float size, std::uint64_t seed) {
  Random random(seed);
  Mesh mesh;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3f at = testing::random_point(random);
    mesh.add(at, at + testing::random_direction(random) * size,
             at + testing::random_direction(random) * size);
  }
  return mesh;
}

Vec3f inside(const Aabb& box, Random& random) {
  const Vec3f e = box.extent(), p = testing::random_point(random);
  return box.lower + Vec3f{e.x * p.x, e.y * p.y, e.z * p.z};
}

TEST(Bundle, SameAnswersAsSingleRays) {
  Random random(3);
  std::size_t blocked = 0, total = 0;
  for (const std::size_t n : {20u, 300u, 5000u}) {
    const Mesh mesh = soup(n, n == 20 ? 0.5f : 0.05f, n);
    const Caster caster = mesh.caster();
    for (int pair = 0; pair < 300; ++pair) {
      Aabb a, b;
      a.add(testing::random_point(random));
      b.add(testing::random_point(random));
      // Points, flat boxes, small and overlapping ones.
      if (pair % 4 != 0) a.add(a.lower + Vec3f{0.1f, pair % 3 == 0 ? 0.0f : 0.2f, 0.05f});
      if (pair % 5 != 0) b.add(b.lower + Vec3f{0.3f, 0.1f, pair % 2 == 0 ? 0.0f : 0.1f});
      Bundle bundle(caster, a, b);
      for (int i = 0; i < 8; ++i) {
        const Vec3f p = inside(a, random), q = inside(b, random);
        Ray ray{p, q - p, 0, i % 2 == 0 ? 1.0f : 0.9999f};
        if (i == 7) ray.t_max = 3;  // leaves the boxes: the ordinary way
        if (i == 6) ray = {q, p - q, 0, 1};
        const bool expected = caster.occluded(ray);
        ASSERT_EQ(bundle.occluded(ray), expected);
        blocked += expected;
        ++total;
        if (i == 5 && bundle.is_clear()) {
          ASSERT_FALSE(expected);
        }
      }
    }
  }
  EXPECT_GT(blocked, total / 10);
  EXPECT_LT(blocked, total * 9 / 10);
}

TEST(Bundle, ClearWhenNothingStandsBetween) {
  Mesh mesh;
  mesh.add({0, 0, 5}, {1, 0, 5}, {0, 1, 5});
  const Caster caster = mesh.caster();
  const Aabb a{{0, 0, 0}, {1, 1, 1}}, b{{10, 0, 0}, {11, 1, 1}};
  EXPECT_TRUE(Bundle(caster, a, b).is_clear());
  const Aabb c{{0, 0, 9}, {1, 1, 10}};
  EXPECT_FALSE(Bundle(caster, a, c).is_clear());
  EXPECT_TRUE(Bundle(caster, a, c).occluded({{0.1f, 0.1f, 0.5f}, {0, 0, 9}, 0, 1}));
  EXPECT_FALSE(Bundle(caster, a, c).occluded({{0.1f, 0.1f, 0.5f}, {0, 0, 9}, 0, 1}, 0));
}

/// The instruction sets agree bit for bit.
TEST(Kernels, GiveTheSameBits) {
#if defined(__x86_64__)
  std::vector<const Kernel*> others;
  if (has_avx2()) others.push_back(&avx2_kernel());
  if (has_avx512()) others.push_back(&avx512_kernel());
  const Mesh mesh = soup(2000, 0.1f, 4);
  const WideTree tree =
      collapse(hierarchy::build(mesh.boxes()), mesh.positions, mesh.triangles, {});
  Random random(9);
  for (int i = 0; i < 20000; ++i) {
    const Ray ray{testing::random_point(random), testing::random_direction(random), 0,
                  random.next_float()};
    const Hit a = baseline_kernel().closest(tree, ray, kNoTriangle, nullptr);
    for (const Kernel* other : others) {
      const Hit b = other->closest(tree, ray, kNoTriangle, nullptr);
      ASSERT_TRUE(a.triangle == b.triangle && a.t == b.t && a.u == b.u && a.v == b.v &&
                  a.back == b.back);
      ASSERT_EQ(baseline_kernel().occluded(tree, ray, 1, 2, nullptr),
                other->occluded(tree, ray, 1, 2, nullptr));
    }
  }
#endif
}

}  // namespace
}  // namespace lightbatch::rays
