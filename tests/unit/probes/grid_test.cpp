#include "core/probes/grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/base/random.h"
#include "tests/unit/accuracy/scene_kit.h"

namespace lightbatch::probes {
namespace {

void add_moving(scene::Scene& scene, std::uint32_t node, const Vec3d& lower, const Vec3d& upper,
                const Vec3d& way = {0, 0, 0}) {
  scene::MovingMesh moving;
  moving.node = node;
  moving.rest.add(lower);
  moving.rest.add(upper);
  moving.swept = moving.rest;
  moving.swept.add(lower + way);
  moving.swept.add(upper + way);
  scene.moving.push_back(moving);
}

/// Cells of a volume that hold a point of it (boundaries count on the lower side).
int cells_at(const Volume& volume, const Vec3d& p) {
  int found = 0;
  for (const Cell& cell : volume.cells) {
    bool inside = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double at = (p[axis] - volume.origin[axis]) / volume.step - cell.at[axis];
      inside = inside && at >= 0 && at < cell.size;
    }
    found += inside ? 1 : 0;
  }
  return found;
}

TEST(Grid, NothingMovesNoProbes) {
  accuracy::SceneKit kit;
  kit.box({0, 0, 0}, {1, 1, 1}, kit.material(Rgb::grey(0.5f)));
  kit.finish();
  const ProbeGrid grid = place_probes(kit.scene(), kit.tree());
  EXPECT_TRUE(grid.volumes.empty());
  EXPECT_TRUE(grid.positions.empty());
}

// Every point of the way lies in one cube, whose corners are where the format says; cubes lie at
// multiples of their size.
TEST(Grid, CubesCoverTheWayOnce) {
  accuracy::SceneKit kit;
  kit.box({-5, 0, -5}, {5, 4, 5}, kit.material(Rgb::grey(0.5f)));
  scene::Scene& scene = kit.scene();
  scene.origin = {100, 0, -3};
  add_moving(scene, 7, scene.origin + Vec3d{-4, 0.1, -1}, scene.origin + Vec3d{-3, 1.9, 0},
             {7, 0, 2});
  kit.finish();
  const ProbeGrid grid = place_probes(scene, kit.tree());
  ASSERT_EQ(grid.volumes.size(), 1u);
  const Volume& volume = grid.volumes[0];
  EXPECT_EQ(volume.nodes, std::vector<std::uint32_t>{7});
  const Aabbd& way = scene.moving[0].swept;
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const Vec3d e = way.extent();
    const Vec3d p = way.lower + Vec3d{e.x * random.next_double(), e.y * random.next_double(),
                                      e.z * random.next_double()};
    ASSERT_EQ(cells_at(volume, p), 1);
  }
  std::set<std::uint32_t> used;
  for (const Cell& cell : volume.cells) {
    for (std::size_t axis = 0; axis < 3; ++axis) ASSERT_EQ(cell.at[axis] % cell.size, 0u);
    ASSERT_LE(cell.size, volume.largest);
    for (std::uint32_t k = 0; k < 8; ++k) {
      used.insert(cell.probe[k]);
      const Vec3d corner =
          volume.origin + Vec3d{static_cast<double>(cell.at[0] + (k & 1) * cell.size),
                                static_cast<double>(cell.at[1] + (k >> 1 & 1) * cell.size),
                                static_cast<double>(cell.at[2] + (k >> 2 & 1) * cell.size)} *
                              volume.step;
      ASSERT_LT(length(grid.positions[cell.probe[k]] - corner), 1e-9);
    }
  }
  EXPECT_EQ(used.size(), grid.positions.size());
}

// A way that starts at the floor and rises: cubes at the floor are smaller than those above.
TEST(Grid, CubesAreSmallerNearGeometry) {
  accuracy::SceneKit kit;
  kit.quad({Vec3f{-9, 0, 9}, {9, 0, 9}, {9, 0, -9}, {-9, 0, -9}}, kit.material(Rgb::grey(0.5f)));
  add_moving(kit.scene(), 0, {0, 0.1, 0}, {1, 1, 1}, {0, 8, 0});
  kit.finish();
  const ProbeGrid grid = place_probes(kit.scene(), kit.tree());
  ASSERT_EQ(grid.volumes.size(), 1u);
  std::uint32_t low = 0, high = 1000;
  for (const Cell& cell : grid.volumes[0].cells) {
    const double bottom = grid.volumes[0].origin.y + grid.volumes[0].step * cell.at[1];
    if (bottom < 0.1) low = std::max(low, cell.size);
    if (bottom > 5) high = std::min(high, cell.size);
  }
  EXPECT_EQ(low, 1u);
  EXPECT_EQ(high, grid.volumes[0].largest);
  EXPECT_GT(high, low);
}

TEST(Grid, FarApartMeansVolumesOfTheirOwn) {
  scene::Scene scene;
  add_moving(scene, 3, {0, 0, 0}, {1, 1, 1});
  add_moving(scene, 1, {0.2, 0, 0}, {1.2, 1, 1});
  add_moving(scene, 2, {100, 0, 0}, {101, 1, 1});
  const ProbeGrid grid = place_probes(scene, {});
  ASSERT_EQ(grid.volumes.size(), 2u);
  std::set<std::vector<std::uint32_t>> nodes;
  for (const Volume& volume : grid.volumes) nodes.insert(volume.nodes);
  EXPECT_EQ(nodes, (std::set<std::vector<std::uint32_t>>{{1, 3}, {2}}));
}

TEST(Grid, ProbesAreBounded) {
  accuracy::SceneKit kit;
  const auto grey = kit.material(Rgb::grey(0.5f));
  Random random(3);
  const auto within = [&](double size) { return size * (random.next_double() - 0.5); };
  for (int i = 0; i < 300; ++i) {
    const Vec3f at = to_float(Vec3d{within(100), within(10), within(100)});
    kit.box(at, at + Vec3f{1, 1, 1}, grey, false);
  }
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const Vec3d at{within(100), within(10), within(100)};
    add_moving(kit.scene(), i, at, at + Vec3d{0.5, 0, 0.5}, {within(10), within(2), 0});
  }
  kit.finish();
  for (const std::uint32_t most : {4096u, 500u, 8u}) {
    const ProbeGrid grid = place_probes(kit.scene(), kit.tree(), {most});
    EXPECT_LE(grid.positions.size(), most);
    EXPECT_GE(grid.positions.size(), 8u);
  }
}

TEST(Grid, APointThatMovesNowhere) {
  scene::Scene scene;
  add_moving(scene, 0, {1, 2, 3}, {1, 2, 3});
  const ProbeGrid grid = place_probes(scene, {});
  ASSERT_EQ(grid.positions.size(), 8u);
  EXPECT_EQ(grid.volumes[0].cells.size(), 1u);
}

}  // namespace
}  // namespace lightbatch::probes
