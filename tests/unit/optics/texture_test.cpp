#include "core/optics/texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/unit/accuracy/scene_kit.h"

namespace lightbatch::optics {
namespace {

using accuracy::SceneKit;

/// Black, then white.
image::Image8 two_pixels() {
  image::Image8 image;
  image.width = 2;
  image.height = 1;
  image.rgba = {0, 0, 0, 255, 255, 255, 255, 255};
  return image;
}

TEST(Texture, FiltersAsTheSamplerSays) {
  const image::Image8 image = two_pixels();
  scene::TextureSlot slot;
  slot.image = 0;
  const auto red = [&](float u) { return sample_texture(image, slot, {u, 0.5f}, false)[0]; };
  EXPECT_FLOAT_EQ(red(0.25f), 0);
  EXPECT_FLOAT_EQ(red(0.5f), 0.5f);
  EXPECT_FLOAT_EQ(red(0.625f), 0.75f);
  slot.filter = scene::Filter::kNearest;
  EXPECT_EQ(red(0.01f), 0);
  EXPECT_EQ(red(0.49f), 0);
  EXPECT_EQ(red(0.51f), 1);
  EXPECT_EQ(red(0.99f), 1);
  EXPECT_EQ(red(1.01f), 0);
  slot.wrap_u = scene::Wrap::kClamp;
  EXPECT_EQ(red(1.01f), 1);
}

TEST(Texture, HugeCoordinatesReadSomeTexel) {
  const image::Image8 image = two_pixels();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const scene::Wrap wrap : {scene::Wrap::kRepeat, scene::Wrap::kClamp, scene::Wrap::kMirror}) {
    scene::TextureSlot slot;
    slot.image = 0;
    slot.wrap_u = slot.wrap_v = wrap;
    for (const float scale : {1.0f, 1e30f, -1e30f, 3e38f}) {
      slot.m00 = slot.m11 = slot.m01 = scale;
      for (const float u : {0.3f, 1e9f, -1e15f, 3e38f, kInfinity, std::nanf("")}) {
        for (const float channel : sample_texture(image, slot, {u, u}, true)) {
          EXPECT_GE(channel, 0) << scale << " " << u;
          EXPECT_LE(channel, 1) << scale << " " << u;
        }
      }
    }
  }
  // Far out, a repeated texture keeps its place as long as floats do.
  scene::TextureSlot slot;
  slot.image = 0;
  slot.tu = 1e7f;
  EXPECT_FLOAT_EQ(sample_texture(image, slot, {0.625f, 0.5f}, false)[0], 0.75f);
}

// What is cut away does not shine, and a sheet shines by its alpha.
TEST(Emission, IsFadedByAlpha) {
  SceneKit kit;
  scene::Material m;
  m.emission = {100, 200, 300};
  m.alpha = 0.25f;
  const auto quad = [&](scene::AlphaMode mode) {
    m.alpha_mode = mode;
    return kit.quad({Vec3f{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, kit.material(m));
  };
  const std::uint32_t opaque = quad(scene::AlphaMode::kOpaque);
  const std::uint32_t mask = quad(scene::AlphaMode::kMask);
  const std::uint32_t blend = quad(scene::AlphaMode::kBlend);
  kit.finish();
  EXPECT_EQ(kit.optics().emission(opaque, 0.2f, 0.2f), (Rgb{100, 200, 300}));
  EXPECT_EQ(kit.optics().emission(blend, 0.2f, 0.2f), (Rgb{25, 50, 75}));
  EXPECT_FALSE(kit.optics().textured_emission(blend));
  EXPECT_FALSE(kit.optics().emits(mask));
}

TEST(Emission, IsTexturedWhereItsCoverageIs) {
  SceneKit kit;
  kit.scene().images.push_back(std::make_shared<const image::Image8>([] {
    image::Image8 holes = two_pixels();
    holes.rgba[3] = 0;
    return holes;
  }()));
  scene::Material m;
  m.emission = Rgb::grey(100);
  m.alpha_mode = scene::AlphaMode::kMask;
  m.base_color_texture.image = 0;
  m.base_color_texture.filter = scene::Filter::kNearest;
  const std::uint32_t lamp =
      kit.quad({Vec3f{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, kit.material(m));
  kit.finish();
  EXPECT_TRUE(kit.optics().textured_emission(lamp));
  // Corners (0, 0), (1, 0), (1, 1) of the unit square.
  EXPECT_EQ(kit.optics().emission(lamp, 0.1f, 0.1f), (Rgb{}));
  EXPECT_EQ(kit.optics().emission(lamp, 0.8f, 0.1f), (Rgb{100, 100, 100}));
}

}  // namespace
}  // namespace lightbatch::optics
