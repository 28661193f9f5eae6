#include "core/rays/grid.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/rays/kernel.h"
#include "tests/unit/rays/oracle.h"

namespace lightbatch::rays {
namespace {

using testing::Mesh;
using testing::random_direction;
using testing::random_point;
using testing::soup;

/// Squares on the planes of a lattice: flat boxes, ties between neighbours, faces on cell borders.
Mesh lattice() {
  Mesh mesh;
  for (int i = 0; i < 6 * 6 * 6; ++i) {
    const Vec3f at{static_cast<float>(i % 6), static_cast<float>(i / 6 % 6),
                   static_cast<float>(i / 36)};
    const auto axis = static_cast<std::size_t>(i % 3);
    Vec3f s, t;
    s[(axis + 1) % 3] = t[(axis + 2) % 3] = 1;
    mesh.add(at, at + s, at + s + t);
    mesh.add(at, at + s + t, at + t);
    if (i % 5 == 0) mesh.add(at, at + s, at + s + t);  // the same once more
  }
  return mesh;
}

/// A closed sphere of shared corners.
Mesh sphere(int rings) {
  Mesh mesh;
  const auto p = [&](int i, int j) {
    const double a = std::numbers::pi * i / rings, b = std::numbers::pi * (j % (2 * rings)) / rings;
    return to_float(i == 0 ? Vec3d{0, 0, 1}
                    : i == rings
                        ? Vec3d{0, 0, -1}
                        : Vec3d{std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)});
  };
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < 2 * rings; ++j) {
      if (i > 0) mesh.add(p(i, j), p(i, j + 1), p(i + 1, j));
      if (i + 1 < rings) mesh.add(p(i + 1, j), p(i, j + 1), p(i + 1, j + 1));
    }
  }
  return mesh;
}

WideTree tree_of(const Mesh& mesh, Grids grids) {
  return collapse(hierarchy::build(mesh.boxes()), mesh.positions, mesh.triangles, {}, grids);
}

std::vector<const Kernel*> kernels() {
  std::vector<const Kernel*> all{&baseline_kernel()};
#if defined(__x86_64__)
  if (has_avx2()) all.push_back(&avx2_kernel());
  if (has_avx512()) all.push_back(&avx512_kernel());
#endif
  return all;
}

void expect_same_answers(const Mesh& mesh, std::span<const Ray> rays) {
  const WideTree plain = tree_of(mesh, Grids::kNever), gridded = tree_of(mesh, Grids::kEverywhere);
  ASSERT_TRUE(plain.grids.empty());
  ASSERT_FALSE(gridded.grids.empty());
  std::size_t hits = 0;
  for (std::size_t first = 0; first < rays.size(); first += 16) {
    std::vector<Segment> segments;
    for (std::size_t i = first; i < std::min(rays.size(), first + 16); ++i) {
      const auto exclude = i % 4 == 0 ? kNoTriangle : static_cast<std::uint32_t>(i % 97);
      segments.push_back({rays[i], exclude});
      const Hit a = baseline_kernel().closest(plain, rays[i], exclude, nullptr);
      hits += a.found() ? 1u : 0u;
      for (const Kernel* kernel : kernels()) {
        const Hit b = kernel->closest(gridded, rays[i], exclude, nullptr);
        ASSERT_TRUE(a.triangle == b.triangle && a.t == b.t && a.u == b.u && a.v == b.v &&
                    a.back == b.back);
        ASSERT_EQ(kernel->occluded(gridded, rays[i], exclude, kNoTriangle, nullptr), a.found());
      }
    }
    std::uint32_t expected = 0;
    baseline_kernel().bundles(plain, segments, {&expected, 1});
    for (const Kernel* kernel : kernels()) {
      std::uint32_t stopped = 0;
      kernel->bundles(gridded, segments, {&stopped, 1});
      ASSERT_EQ(stopped, expected);
    }
  }
  EXPECT_GT(hits, rays.size() / 20);
  EXPECT_LT(hits, rays.size());
}

TEST(Grid, SameAnswersAsTheTree) {
  Random random(2);
  for (const float size : {0.02f, 0.1f, 0.5f}) {
    const Mesh mesh = soup(1000, size, 7);
    std::vector<Ray> rays;
    for (int i = 0; i < 4000; ++i) {
      const Vec3f p = random_point(random), d = random_direction(random);
      // From inside, from near by, from far away; short and endless.
      const float away = i % 4 == 0 ? 0.0f : i % 4 == 1 ? 3.0f : i % 4 == 2 ? 500.0f : 1e5f;
      Ray ray{p - d * away, d};
      if (i % 8 == 0) ray.t_max = 0.4f;
      if (i % 8 == 4) ray.t_min = 0.1f;
      rays.push_back(ray);
    }
    expect_same_answers(mesh, rays);
  }
}

TEST(Grid, OddRays) {
  Random random(3);
  std::vector<Ray> rays;
  for (int i = 0; i < 2000; ++i) {
    Ray ray{random_point(random), random_direction(random)};
    if (i % 8 == 0) ray.direction = {0, 0, i % 16 == 0 ? 1.0f : -1.0f};
    if (i % 8 == 1) ray.direction = {-1, 0, 0};
    if (i % 8 == 2) ray.direction = {1, i % 16 == 2 ? 1.0f : -1.0f, 0};
    if (i % 8 == 3) ray.direction = ray.direction * 1e-30f;
    if (i % 8 == 4) ray.direction = ray.direction * 1e25f;
    if (i % 8 == 5) ray.t_min = -std::numeric_limits<float>::infinity();
    if (i % 8 == 6) ray.t_max = -0.1f, ray.t_min = -5;
    rays.push_back(ray);
  }
  expect_same_answers(soup(800, 0.2f, 5), rays);
}

/// Rays in the planes of cells and faces, along edges, through corners.
TEST(Grid, FlatBoxesAndTies) {
  Random random(4);
  const auto place = [&] { return static_cast<float>(random.below(13)) * 0.5f; };
  std::vector<Ray> rays;
  for (int i = 0; i < 6000; ++i) {
    const Vec3f from{place() - 1, place(), place()}, to{place(), place(), place() + 0.25f};
    rays.push_back({from, to - from, 0, i % 3 == 0 ? 1.0f : 10.0f});
  }
  expect_same_answers(lattice(), rays);
}

/// Flat as a whole, far from the origin, in a point.
TEST(Grid, DegenerateBoxes) {
  Mesh flat = soup(500, 0.1f, 6);
  for (Vec3f& p : flat.positions) p.y = 0.25f;
  Mesh far_away = soup(500, 0.1f, 6);
  for (Vec3f& p : far_away.positions) p = p + Vec3f{1e4f, -1e4f, 1e4f};
  Random random(5);
  std::vector<Ray> down, aside;
  for (int i = 0; i < 2000; ++i) {
    const Vec3f above = random_point(random) + Vec3f{0, 0.5f, 0};
    down.push_back({above, random_point(random) - above});
    aside.push_back({random_point(random) + Vec3f{1e4f, -1e4f, 1e4f}, random_direction(random)});
  }
  expect_same_answers(flat, down);
  expect_same_answers(far_away, aside);
  Mesh point;
  for (int i = 0; i < 100; ++i) point.add({1, 2, 3}, {1, 2, 3}, {1, 2, 3});
  const WideTree tree = tree_of(point, Grids::kEverywhere);
  EXPECT_FALSE(kernel().closest(tree, {{0, 0, 0}, {1, 2, 3}, 0, 10}, kNoTriangle, nullptr).found());
}

TEST(Grid, Watertight) {
  const Mesh mesh = sphere(24);
  const Caster caster(hierarchy::build(mesh.boxes()), mesh.positions, mesh.triangles, {},
                      Grids::kEverywhere);
  ASSERT_EQ(caster.grids().size(), 1u);
  Random random(6);
  for (int i = 0; i < 20000; ++i) {
    const auto& t = mesh.triangles[random.below(mesh.triangles.size())];
    const Vec3f a = mesh.positions[t[0]], b = mesh.positions[t[1]];
    const Vec3f from = (random_point(random) - Vec3f{0.5f, 0.5f, 0.5f}) * 0.5f;
    const Vec3f at = i % 2 == 0 ? a : (a + b) * 0.5f;
    ASSERT_TRUE(caster.closest({from, at - from}).found());
    ASSERT_TRUE(caster.occluded({from, at - from}));
  }
}

/// A triangle is asked about once at most, so grids hold none that ask.
TEST(Grid, FiltersStayOutside) {
  const Mesh mesh = soup(2000, 0.05f, 9);
  std::vector<Surface> surfaces(mesh.triangles.size(), Surface::kOpaque);
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if (mesh.positions[mesh.triangles[i][0]].x > 0.5f) surfaces[i] = Surface::kFiltered;
  }
  const hierarchy::Hierarchy tree = hierarchy::build(mesh.boxes());
  const Caster caster(tree, mesh.positions, mesh.triangles, surfaces, Grids::kEverywhere);
  ASSERT_FALSE(caster.grids().empty());
  for (const GridNode& grid : caster.grids()) {
    for (const std::uint32_t i : tree.primitives(grid.node)) {
      ASSERT_EQ(surfaces[i], Surface::kOpaque);
    }
  }
}

/// Without a look at the members no cost is promised that the best layout does not reach.
TEST(Grid, LeastCostIsABound) {
  const Mesh mesh = soup(3000, 0.03f, 1);
  Aabb box;
  std::vector<GridMember> members;
  for (const Aabb& b : mesh.boxes()) {
    members.push_back({b, 1, 0});
    box.add(b);
  }
  const GridPlan plan = plan_grid(box, members);
  EXPECT_LT(least_grid_cost(box, 3000), plan.cost);
  const std::vector<std::uint32_t> words = fill_grid(plan.layout, members);
  EXPECT_EQ(words.size(), plan.layout.cell_count() + 1 + words[plan.layout.cell_count()]);
  EXPECT_GE(words[plan.layout.cell_count()], 3000u);
}

}  // namespace
}  // namespace lightbatch::rays
