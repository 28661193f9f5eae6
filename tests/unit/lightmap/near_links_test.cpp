#include "core/lightmap/near_links.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/accuracy/path_tracer.h"
#include "tests/unit/lightmap/lit_scene.h"

namespace lightbatch::lightmap {
namespace {

TEST(NearLinks, LinksToOneTexelBecomeOne) {
  std::vector<NearLink> links{{7, Rgb::grey(0.25f)}, {2, Rgb::grey(0.5f)}, {7, Rgb::grey(0.5f)}};
  NearLinks::merge(links);
  ASSERT_EQ(links.size(), 2u);
  EXPECT_EQ(links[0].texel, 2u);
  EXPECT_EQ(links[1].texel, 7u);
  EXPECT_EQ(links[1].weight.g, 0.75f);
}

// Texels 0 and 1 see each other, 1 also sees 2, whose light nobody knows: for that one the first
// stage has to do. E0 = 10 + E1 / 2; E1 = 4 + E0 / 4 + 20 / 4.
TEST(NearLinks, TexelsAreSolvedTogether) {
  const std::vector<Rgb> first{Rgb::grey(8), Rgb::grey(12), Rgb::grey(20)};
  NearLinks links(3);
  const std::uint32_t rows[] = {0, 1}, counts[] = {1, 2};
  const NearLink both[] = {{1, Rgb::grey(0.5f)}, {0, Rgb::grey(0.25f)}, {2, Rgb::grey(0.25f)}};
  links.add(rows, counts, {std::begin(both), std::end(both)});
  std::vector<GatheredTexel> texels(3);
  texels[0].irradiance = Rgb::grey(10 + 12 * 0.5f);
  texels[1].irradiance = Rgb::grey(4 + 8 * 0.25f + 20 * 0.25f);
  radiosity::GroupedLight by_group(3, 2);
  by_group.of(0)[0] = Rgb::grey(10);
  by_group.of(1)[1] = Rgb::grey(4);
  const NearLinks::Start start{{texels[0].irradiance, texels[1].irradiance, {}}, by_group};
  // One step, from what the neighbours have now: 4 + 16 / 4 + 20 / 4.
  EXPECT_NEAR(static_cast<double>(links.linked(1, first, {1, 1, 0}, start, texels).g), 13, 1e-5);
  int fills = 0;
  links.solve(first, {1, 1, 0}, start, texels, by_group, [&] { ++fills; });
  EXPECT_GT(fills, 1);
  const double e1 = (9 + 2.5) / (1 - 0.125), e0 = 10 + e1 / 2;
  // Iteration stops at changes of 1e-4, of which 1/8 is still to come.
  EXPECT_NEAR(static_cast<double>(texels[0].irradiance.g), e0, 1e-3 * e0);
  EXPECT_NEAR(static_cast<double>(texels[1].irradiance.g), e1, 1e-3 * e1);
  // By group: what texel 0 has of its own, through 1 and back; texel 2 brings nothing.
  EXPECT_NEAR(static_cast<double>(by_group.of(0)[0].g), 10 / (1 - 0.125), 0.02);
  EXPECT_NEAR(static_cast<double>(by_group.of(0)[1].g), 2 / (1 - 0.125), 0.01);
}

// The first stage may know the sum: the groups, of which it knows nothing, are still to be found.
TEST(NearLinks, GroupsAddUpToTheLight) {
  NearLinks links(2);
  const std::uint32_t rows[] = {0, 1}, counts[] = {1, 1};
  const NearLink both[] = {{1, Rgb::grey(0.5f)}, {0, Rgb::grey(0.8f)}};
  links.add(rows, counts, {std::begin(both), std::end(both)});
  // E0 = 1 + E1 / 2, E1 = 2 + 0.8 E0: 10 / 3 and 14 / 3.
  const std::vector<Rgb> solved{Rgb::grey(10.0f / 3), Rgb::grey(14.0f / 3)};
  std::vector<GatheredTexel> texels(2);
  texels[0].irradiance = solved[0];
  texels[1].irradiance = solved[1];
  radiosity::GroupedLight by_group(2, 2);
  by_group.of(0)[0] = Rgb::grey(1);
  by_group.of(1)[1] = Rgb::grey(2);
  links.solve(solved, {1, 1}, {solved, by_group}, texels, by_group, [] {});
  for (std::size_t t = 0; t < 2; ++t) {
    const float sum = by_group.of(t)[0].g + by_group.of(t)[1].g;
    EXPECT_NEAR(static_cast<double>(sum / texels[t].irradiance.g), 1, 1e-3) << t;
    EXPECT_NEAR(static_cast<double>(texels[t].irradiance.g / solved[t].g), 1, 1e-5) << t;
  }
}

// A pipe through a floor: a texel of the pipe that has both sides of the floor is no link.
TEST(NearTexels, ACurvedTexelThroughAFloorIsNotWhole) {
  LitScene lit;
  auto& kit = lit.kit;
  const std::uint32_t white = kit.material(Rgb::grey(0.8f));
  constexpr float kRadius = 0.1f;
  const auto at = [&](int k, float y) {
    const double angle = k * 0.4;
    return Vec3f{kRadius * static_cast<float>(std::cos(angle)), y,
                 kRadius * static_cast<float>(std::sin(angle))};
  };
  for (int k = 0; k < 4; ++k) {
    kit.quad({{at(k + 1, -0.4f), at(k, -0.4f), at(k, 0.4f), at(k + 1, 0.4f)}}, white);
  }
  // One object, whose facets make one chart.
  scene::Scene& scene = kit.scene();
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
    scene.triangles[t].object = 0;
    scene.triangles[t].source = t;
  }
  scene.objects.resize(1);
  scene.objects[0].triangle_count = 8;
  constexpr float kFloor = 0.013f;
  kit.quad({{{-1, kFloor, -1}, {-1, kFloor, 1}, {1, kFloor, 1}, {1, kFloor, -1}}}, white);
  kit.quad({{{1, kFloor, -1}, {1, kFloor, 1}, {-1, kFloor, 1}, {-1, kFloor, -1}}}, white);
  lit.sky = optics::Environment(Rgb::grey(100));
  lit.edge = 10;
  lit.chart(25);
  lit.solve();
  ASSERT_EQ(lit.layout.chart_of[0], lit.layout.chart_of[7]);
  const BakeInput input = lit.input();
  const NearTexels near(input, 0.3);
  int through = 0, whole = 0;
  for (std::uint32_t t = 0; t < lit.texels.texels.size(); ++t) {
    const TexelPoints points = texel_points(lit.texels, lit.texels.texels[t]);
    if (points.point[0].triangle >= 8) continue;
    float low = 1, high = -1, straight = 1;
    const Vec3f up = receiver_at(scene, lit.layout, points.point[0], 0).frame.normal;
    for (std::uint32_t i = 0; i < points.count; ++i) {
      const auto frame = receiver_at(scene, lit.layout, points.point[i], 0).frame;
      low = std::min(low, frame.position.y);
      high = std::max(high, frame.position.y);
      straight = std::min(straight, dot(up, frame.normal));
    }
    if (straight > 0.99f) continue;
    const auto p = surface_point(lit.layout, points.point[0]);
    const std::uint32_t link = near.at({p.triangle, 0.1f, p.u, p.v, false}, 0.1f, 10);
    if (low < kFloor && high > kFloor) {
      ++through;
      EXPECT_EQ(link, scene::kNone) << t;
    } else {
      ++whole;
      EXPECT_EQ(link, t);
    }
  }
  EXPECT_GT(through, 0);
  EXPECT_GT(whole, 20);
}

/// A white shelf of two boards, 12 cm apart, under a sky; cells of 50 cm see nothing of that.
struct Shelf {
  LitScene lit;
  Shelf() {
    auto& kit = lit.kit;
    const std::uint32_t white = kit.material(Rgb::grey(0.8f));
    kit.box({0, 0, 0}, {2, 0.04f, 0.6f}, white, false);
    kit.box({0, 0.16f, 0}, {2, 0.2f, 0.6f}, white, false);
    lit.sky = optics::Environment(Rgb::grey(100));
    lit.edge = 0.5;
    lit.chart(20);
    lit.solve();
  }
};

TEST(NearLinks, BetweenBoardsAsPathTracing) {
  const Shelf shelf;
  GatherSettings settings;
  settings.rays = 256;
  settings.block = 1;
  radiosity::GroupedLight none;
  BakeCounts linked, walked;
  const DimShares dim(shelf.lit.input(), settings);
  const auto with = bake_indirect(shelf.lit.input(), settings, dim, none, linked, Progress{});
  settings.linked = 1e9;
  const auto without = bake_indirect(shelf.lit.input(), settings, dim, none, walked, Progress{});
  EXPECT_GT(linked.near_links, linked.deeper_gathers / 2);
  EXPECT_EQ(walked.near_links, 0u);
  EXPECT_LT(linked.rays.cast(), walked.rays.cast());
  const accuracy::PathTracer tracer(shelf.lit.kit.caster(), shelf.lit.kit.optics(), shelf.lit.sky);
  double truth = 0, mean = 0, squares = 0, walked_squares = 0;
  for (std::uint32_t t = 0; t < with.size(); t += 29) {
    const double want = tracer.irradiance(shelf.lit.points_of(t), 8192, t).irradiance.g;
    const double got = static_cast<double>(with[t].g);
    truth += want;
    mean += got;
    squares += (got - want) * (got - want);
    walked_squares += std::pow(static_cast<double>(without[t].g) - want, 2);
  }
  EXPECT_NEAR(mean / truth, 1, 0.01);
  EXPECT_LT(squares, 1.2 * walked_squares);
}

}  // namespace
}  // namespace lightbatch::lightmap
