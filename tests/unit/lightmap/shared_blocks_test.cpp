#include "core/lightmap/shared_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/lightmap/neighbours.h"
#include "tests/unit/lightmap/lit_scene.h"

namespace lightbatch::lightmap {
namespace {

/// A floor whose texels hold what the test says, as if all of them had been gathered.
struct Floor {
  LitScene lit;
  GatherSettings settings;
  BakeInput input;
  DimShares dim;
  GatheredMap map;
  SharedBlocks blocks;
  int x0, y0;

  static LitScene made() {
    LitScene lit;
    const std::uint32_t white = lit.kit.material(Rgb::grey(0.8f));
    lit.kit.quad({{{0, 0, 0}, {0, 0, 2}, {2, 0, 2}, {2, 0, 0}}}, white);
    lit.sky = optics::Environment(Rgb::grey(100));
    lit.chart(8);
    lit.solve();
    return lit;
  }

  Floor()
      : lit(made()),
        input(lit.input()),
        dim(input, settings),
        map(lit.texels.texels.size(), 0),
        blocks(input, settings, dim, map),
        x0(lit.layout.charts[0].x + 2),
        y0(lit.layout.charts[0].y + 2) {}

  std::uint32_t texel(int x, int y) const {
    return texel_at(lit.texels, lit.layout, 0, x0 + x, y0 + y);
  }
  Block block(int width, int height) const { return {0, x0, y0, x0 + width, y0 + height}; }
  void set(int x, int y, double light, TexelState state = TexelState::kComputed) {
    GatheredTexel& t = map.texel[texel(x, y)];
    t.irradiance = Rgb::grey(static_cast<float>(light * input.mean_irradiance));
    t.distance = 100;
    t.normal = {0, 1, 0};
    t.gathered = state == TexelState::kComputed;
    map.state[texel(x, y)] = state;
  }
  std::vector<std::uint32_t> asked(const Block& b) const {
    std::vector<std::uint32_t> all;
    blocks.for_each_asked(b, [&](std::uint32_t t) { all.push_back(t); });
    return all;
  }
};

TEST(SharedBlocks, EvenLightIsSharedAndAPeakIsNot) {
  Floor floor;
  const Block b = floor.block(4, 4);
  for (const auto& at : {Vec2d{0, 0}, {4, 0}, {0, 4}, {4, 4}, {2, 2}}) {
    floor.set(static_cast<int>(at.x), static_cast<int>(at.y), 1 + at.x / 10);
  }
  EXPECT_EQ(floor.asked(b).size(), 5u);
  EXPECT_TRUE(floor.blocks.is_predicted(b));
  floor.blocks.fill(b);
  const GatheredTexel& filled = floor.map.texel[floor.texel(1, 3)];
  EXPECT_NEAR(static_cast<double>(filled.irradiance.g), 1.1 * floor.input.mean_irradiance,
              1e-5 * floor.input.mean_irradiance);
  floor.blocks.clear(b);
  EXPECT_EQ(floor.map.state[floor.texel(1, 3)], TexelState::kUnknown);
  EXPECT_EQ(floor.map.state[floor.texel(2, 2)], TexelState::kComputed);
  floor.set(2, 2, 1.6);
  EXPECT_FALSE(floor.blocks.is_predicted(b));
}

// As at the mouth of a crack: one row of texels is dark, the other is lit here and there.
TEST(SharedBlocks, BothRowsOfAStripAreAsked) {
  Floor floor;
  const Block b = floor.block(4, 1);
  for (const int x : {0, 2, 4}) {
    floor.set(x, 0, 0);
    floor.set(x, 1, 1);
  }
  std::vector<std::uint32_t> asked = floor.asked(b);
  EXPECT_EQ(std::count(asked.begin(), asked.end(), floor.texel(2, 0)), 1);
  EXPECT_EQ(std::count(asked.begin(), asked.end(), floor.texel(2, 1)), 1);
  EXPECT_TRUE(floor.blocks.is_predicted(b));
  floor.set(2, 1, 2);
  EXPECT_FALSE(floor.blocks.is_predicted(b));
  floor.set(2, 1, 1);
  floor.set(2, 0, 2);
  EXPECT_FALSE(floor.blocks.is_predicted(b));
  // A border that a larger block has filled is as that block has it, and no reason to cut this one.
  floor.set(2, 0, 2, TexelState::kShared);
  EXPECT_TRUE(floor.blocks.is_predicted(b));
  floor.set(2, 1, 2);
  EXPECT_FALSE(floor.blocks.is_predicted(b));
}

TEST(SharedBlocks, PartsCoverTheBlock) {
  Floor floor;
  std::vector<Block> parts;
  SharedBlocks::cut(floor.block(5, 1), parts);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].x1, parts[1].x0);
  EXPECT_EQ(parts[1].x1, floor.block(5, 1).x1);
  parts.clear();
  SharedBlocks::cut(floor.block(4, 3), parts);
  EXPECT_EQ(parts.size(), 4u);
  parts.clear();
  SharedBlocks::cut(floor.block(1, 1), parts);
  EXPECT_TRUE(parts.empty());
}

}  // namespace
}  // namespace lightbatch::lightmap
