#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <vector>

#include "core/rays/kernel.h"
#include "tests/unit/rays/oracle.h"

namespace lightbatch::rays {
namespace {

using testing::Mesh;
using testing::soup;

Vec3f inside(const Aabb& box, Random& random) {
  const Vec3f e = box.extent(), p = testing::random_point(random);
  return box.lower + Vec3f{e.x * p.x, e.y * p.y, e.z * p.z};
}

std::vector<const Kernel*> kernels() {
  std::vector<const Kernel*> all{&baseline_kernel()};
#if defined(__x86_64__)
  if (has_avx2()) all.push_back(&avx2_kernel());
  if (has_avx512()) all.push_back(&avx512_kernel());
#endif
  return all;
}

unsigned together(const Kernel& kernel, const WideTree& tree,
                  const std::vector<Segment>& segments) {
  std::uint32_t stopped = 0;
  kernel.bundles(tree, segments, {&stopped, 1});
  return stopped;
}

unsigned one_by_one(const WideTree& tree, const std::vector<Segment>& segments) {
  unsigned expected = 0;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Segment& s = segments[i];
    const bool stopped = baseline_kernel().occluded(tree, s.ray, s.exclude_a, s.exclude_b, nullptr);
    expected |= stopped ? 1u << i : 0u;
  }
  return expected;
}

WideTree tree_of(const Mesh& mesh) {
  return collapse(hierarchy::build(mesh.boxes()), mesh.positions, mesh.triangles, {});
}

TEST(Packet, SameAnswersAsSingleRays) {
  Random random(3);
  std::size_t blocked = 0, total = 0;
  for (const std::size_t n : {20u, 300u, 5000u}) {
    const Mesh mesh = soup(n, n == 20 ? 0.5f : 0.05f, n);
    const WideTree tree = tree_of(mesh);
    for (int pair = 0; pair < 400; ++pair) {
      // From points, flat boxes, small and large ones, also overlapping.
      Aabb a, b;
      a.add(testing::random_point(random));
      b.add(testing::random_point(random));
      if (pair % 4 != 0) a.add(a.lower + Vec3f{0.1f, pair % 3 == 0 ? 0.0f : 0.2f, 0.05f});
      if (pair % 5 != 0) b.add(b.lower + Vec3f{0.3f, 0.1f, pair % 2 == 0 ? 0.0f : 0.1f});
      std::vector<Segment> segments;
      const std::size_t count = pair % 3 == 0 ? 1 + random.below(16) : 16;
      for (std::size_t i = 0; i < count; ++i) {
        const Vec3f p = inside(a, random), q = inside(b, random);
        segments.push_back({{p, q - p, 0, i % 2 == 0 ? 1.0f : 0.9f},
                            static_cast<std::uint32_t>(random.below(n)),
                            i % 4 == 0 ? kNoTriangle : static_cast<std::uint32_t>(i)});
        if (i % 5 == 4) std::swap(segments.back().exclude_a, segments.back().exclude_b);
      }
      const unsigned expected = one_by_one(tree, segments);
      for (const Kernel* kernel : kernels()) ASSERT_EQ(together(*kernel, tree, segments), expected);
      blocked += static_cast<std::size_t>(std::popcount(expected));
      total += count;
    }
  }
  EXPECT_GT(blocked, total / 10);
  EXPECT_LT(blocked, total * 9 / 10);
}

/// Every kind of ray that does not fit in with the others: steep, endless, nonsense, backwards.
TEST(Packet, OddOnesOut) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const Mesh mesh = soup(300, 0.2f, 8);
  const WideTree tree = tree_of(mesh);
  Random random(4);
  for (int round = 0; round < 300; ++round) {
    std::vector<Segment> segments;
    for (int i = 0; i < 16; ++i) {
      const Vec3f p = testing::random_point(random), q = testing::random_point(random);
      Ray ray{p, q - p, 0, 1};
      switch (random.below(12)) {
        case 0:
          ray.t_max = kInf;
          break;
        case 1:
          ray.t_min = -0.5f;
          break;
        case 2:
          ray.direction = {0, 0, 0};
          break;
        case 3:
          ray.direction = {0, 0, round % 2 == 0 ? 1.0f : -1.0f};
          break;
        case 4:
          ray.origin.x = kNan;
          break;
        case 5:
          ray.direction.y = kInf;
          break;
        case 6:
          ray.t_max = kNan;
          break;
        case 7:
          ray.t_min = 2;
          break;
        case 8:
          ray.direction = ray.direction * 1e-20f;
          ray.t_max = 1e20f;
          break;
        default:
          break;
      }
      segments.push_back({ray});
    }
    const unsigned expected = one_by_one(tree, segments);
    for (const Kernel* kernel : kernels()) ASSERT_EQ(together(*kernel, tree, segments), expected);
  }
}

/// Segments along edges and through corners of squares, where only the exact test can tell.
TEST(Packet, EdgesAndCorners) {
  Mesh mesh;
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      const Vec3f at{static_cast<float>(x), static_cast<float>(y), 1};
      mesh.add(at, at + Vec3f{1, 0, 0}, at + Vec3f{1, 1, 0});
      mesh.add(at, at + Vec3f{1, 1, 0}, at + Vec3f{0, 1, 0});
    }
  }
  const WideTree tree = tree_of(mesh);
  Random random(6);
  for (int round = 0; round < 200; ++round) {
    std::vector<Segment> segments;
    for (int i = 0; i < 16; ++i) {
      const Vec3f target{static_cast<float>(random.below(17)) / 2,
                         static_cast<float>(random.below(17)) / 2, 1};
      const Vec3f from{4 + random.next_float(), 4 + random.next_float(), 0};
      segments.push_back({{from, target - from, 0, i % 3 == 0 ? 1.0f : 1.5f}});
    }
    const unsigned expected = one_by_one(tree, segments);
    EXPECT_NE(expected, 0u);
    for (const Kernel* kernel : kernels()) ASSERT_EQ(together(*kernel, tree, segments), expected);
  }
}

/// Any number of bundles, each with its own answers; one after another and, in a tree larger than
/// the caches, in turns. Segments are strewn, or as links have them: between two small places.
class ManyBundles : public ::testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Trees, ManyBundles, ::testing::Values(3000u, 400000u));

TEST_P(ManyBundles, EachItsAnswers) {
  const Mesh mesh = soup(GetParam(), GetParam() > 3000 ? 0.005f : 0.05f, 12);
  const WideTree tree = tree_of(mesh);
  EXPECT_EQ(tree.data.size() > (std::size_t{16} << 20), GetParam() > 3000);
  Random random(7);
  for (const std::size_t number : {1u, 16u, 17u, 64u, 65u, 1000u, 1001u}) {
    const float width = number % 2 == 0 ? 0.02f : 1.0f;
    std::vector<Segment> segments;
    Vec3f from, to;
    for (std::size_t i = 0; i < number; ++i) {
      if (i % 16 == 0 || width == 1.0f) {
        from = testing::random_point(random);
        to = testing::random_point(random);
      }
      const Vec3f p = from + testing::random_direction(random) * width * 0.5f;
      const Vec3f q = to + testing::random_direction(random) * width * 0.5f;
      segments.push_back({{p, q - p, 0, 1}});
    }
    std::vector<std::uint32_t> expected((number + 15) / 16, 0u);
    for (std::size_t i = 0; i < number; ++i) {
      const bool stopped =
          baseline_kernel().occluded(tree, segments[i].ray, kNoTriangle, kNoTriangle, nullptr);
      expected[i / 16] |= stopped ? 1u << (i % 16) : 0u;
    }
    for (const Kernel* kernel : kernels()) {
      std::vector<std::uint32_t> stopped(expected.size());
      kernel->bundles(tree, segments, stopped);
      ASSERT_EQ(stopped, expected);
    }
  }
}

TEST(Packet, NothingThereAndNothingAsked) {
  const Mesh empty;
  const Mesh mesh = soup(20, 0.5f, 1);
  for (const Mesh* m : {&empty, &mesh}) {
    const Caster caster = m->caster();
    caster.occluded({}, {});
    std::vector<std::uint32_t> stopped(3, 7u);
    caster.occluded(std::vector<Segment>(35), stopped);
    EXPECT_EQ(stopped, std::vector<std::uint32_t>(3, 0u));
  }
}

/// The instruction sets agree bit for bit.
TEST(Kernels, GiveTheSameBits) {
  const Mesh mesh = soup(2000, 0.1f, 4);
  const WideTree tree =
      collapse(hierarchy::build(mesh.boxes()), mesh.positions, mesh.triangles, {});
  Random random(9);
  for (int i = 0; i < 20000; ++i) {
    const Ray ray{testing::random_point(random), testing::random_direction(random), 0,
                  random.next_float()};
    const Hit a = baseline_kernel().closest(tree, ray, kNoTriangle, nullptr);
    for (const Kernel* other : kernels()) {
      const Hit b = other->closest(tree, ray, kNoTriangle, nullptr);
      ASSERT_TRUE(a.triangle == b.triangle && a.t == b.t && a.u == b.u && a.v == b.v &&
                  a.back == b.back);
      ASSERT_EQ(baseline_kernel().occluded(tree, ray, 1, 2, nullptr),
                other->occluded(tree, ray, 1, 2, nullptr));
    }
  }
}

}  // namespace
}  // namespace lightbatch::rays
