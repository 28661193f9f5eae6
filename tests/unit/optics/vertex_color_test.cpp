#include <gtest/gtest.h>

#include "tests/unit/accuracy/scene_kit.h"

namespace lightbatch::optics {
namespace {

using accuracy::SceneKit;

/// A quad of reflectance 0.5 and, by its side, one without colours.
struct TwoQuads {
  SceneKit kit;
  explicit TwoQuads(scene::AlphaMode mode, const std::array<scene::VertexColor, 4>& colors) {
    scene::Material m;
    m.base_color = Rgb::grey(0.5f);
    m.metallic = 0;
    m.alpha_mode = mode;
    const std::uint32_t material = kit.material(m);
    kit.quad({Vec3f{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, material);
    kit.quad({Vec3f{2, 0, 0}, {3, 0, 0}, {3, 1, 0}, {2, 1, 0}}, material);
    kit.scene().colors.assign(colors.begin(), colors.end());
    kit.scene().colors.resize(8);
    kit.finish();
  }
};

// glTF 2.0, 3.7.2.1: COLOR_0 multiplies the base colour, linearly between the corners.
TEST(VertexColor, IsAFactorOfReflectance) {
  const TwoQuads quads(scene::AlphaMode::kOpaque,
                       {scene::VertexColor{{1, 0, 0}, 1}, {{0, 1, 0}, 1}, {{0, 0, 1}, 1}, {}});
  const Optics& optics = quads.kit.optics();
  const Rgb middle = optics.reflectance(0, 0.25f, 0.5f);
  EXPECT_FLOAT_EQ(middle.r, 0.125f);
  EXPECT_FLOAT_EQ(middle.g, 0.125f);
  EXPECT_FLOAT_EQ(middle.b, 0.25f);
  EXPECT_TRUE(optics.textured_reflectance(0));
  EXPECT_EQ(optics.reflectance(2, 0.25f, 0.5f), Rgb::grey(0.5f));
  EXPECT_FALSE(optics.textured_reflectance(2));
}

// Alpha of 0, of 0 to 1, and of 1 against a cutoff of one half.
TEST(VertexColor, AlphaCutsOut) {
  for (const auto& [low, high, surface] : {std::tuple{0.0f, 0.0f, rays::Surface::kClear},
                                           {0.0f, 1.0f, rays::Surface::kFiltered},
                                           {1.0f, 1.0f, rays::Surface::kOpaque}}) {
    const scene::VertexColor a{{1, 1, 1}, low}, b{{1, 1, 1}, high};
    const TwoQuads quads(scene::AlphaMode::kMask, {a, b, b, b});
    EXPECT_EQ(quads.kit.optics().surfaces()[0], surface) << low << " to " << high;
    EXPECT_EQ(quads.kit.optics().surfaces()[2], rays::Surface::kOpaque);
  }
}

/// Half there at the middle of its first edge: what is there reflects as ever.
TEST(VertexColor, AlphaIsCoverage) {
  const scene::VertexColor a{{1, 1, 1}, 0}, b{{1, 1, 1}, 1};
  const TwoQuads quads(scene::AlphaMode::kBlend, {a, b, b, b});
  const Optics& optics = quads.kit.optics();
  const Optics::Scatterer middle = optics.scatterer(0, 0.5f, 0);
  EXPECT_FLOAT_EQ(middle.coverage, 0.5f);
  EXPECT_FLOAT_EQ(middle.reflectance.g, 0.5f);
  EXPECT_FLOAT_EQ(optics.reflectance(0, 0.5f, 0).g, 0.25f);
  EXPECT_FLOAT_EQ(optics.transmittance(0, 0.5f, 0).g, 0.5f);
  EXPECT_FLOAT_EQ(optics.scatterer(2, 0.5f, 0).coverage, 1);
}

}  // namespace
}  // namespace lightbatch::optics
