#include "core/plan/effect_plan.h"

#include <gtest/gtest.h>

#include "tests/unit/accuracy/scene_kit.h"

namespace lightbatch::plan {
namespace {

using accuracy::SceneKit;

const optics::Environment kSky{Rgb::grey(100)};

EffectPlan plan_of(SceneKit& kit, const optics::Environment& sky = {},
                   const std::vector<std::string>& overrides = {}) {
  kit.finish();
  auto plan = make_plan(kit.scene(), kit.optics(), kit.caster(), sky, 0.02, overrides);
  EXPECT_TRUE(plan.ok()) << plan.status().to_string();
  return plan.ok() ? std::move(plan).value() : EffectPlan{};
}

void add_moving(SceneKit& kit, const Vec3d& lower, const Vec3d& upper) {
  scene::MovingMesh moving;
  moving.name = "cart";
  moving.node = 4;
  moving.rest.add(lower);
  moving.rest.add(upper);
  moving.swept = moving.rest;
  kit.scene().moving.push_back(moving);
}

void add_floor(SceneKit& kit) {
  kit.quad({Vec3f{-5, 0, 5}, {5, 0, 5}, {5, 0, -5}, {-5, 0, -5}}, kit.material(Rgb::grey(0.5f)));
}

scene::Light lamp(const Vec3d& at, double range = 0) {
  scene::Light light;
  light.position = at;
  light.intensity = Rgb::grey(10);
  light.range = range;
  return light;
}

TEST(EffectPlan, AnEmptySceneCallsForNothing) {
  SceneKit kit;
  const EffectPlan plan = plan_of(kit, kSky);
  for (const Decision& d : plan.decisions) EXPECT_FALSE(d.on || d.called_for) << d.reason;
}

TEST(EffectPlan, ProbesNeedLightAndSomethingThatMoves) {
  SceneKit still, dark, lit;
  for (SceneKit* kit : {&still, &dark, &lit}) add_floor(*kit);
  still.scene().lights.push_back(lamp({0, 2, 0}));
  EXPECT_FALSE(plan_of(still).on(Effect::kProbes));
  add_moving(dark, {0, 1, 0}, {1, 2, 1});
  EXPECT_FALSE(plan_of(dark).on(Effect::kProbes));
  add_moving(lit, {0, 1, 0}, {1, 2, 1});
  lit.scene().lights.push_back(lamp({0, 2, 0}));
  const EffectPlan plan = plan_of(lit);
  EXPECT_TRUE(plan.on(Effect::kProbes));
  EXPECT_EQ(plan[Effect::kProbes].evidence, std::vector<std::string>{"node 4 cart"});
  EXPECT_FALSE(plan_of(lit, {}, {"-probes"}).on(Effect::kProbes));
  auto refused = make_plan(still.scene(), still.optics(), still.caster(), {}, 0.02, {"+probes"});
  EXPECT_EQ(refused.status().reason(), "BAD_OPTION");
}

// Above a lone floor nothing is reflected onto a surface, and nothing shades one, but a probe gets
// light from the floor and, below it, none from the lamp.
TEST(EffectPlan, ProbesCallForWhatTheyAloneSee) {
  SceneKit still, moving;
  for (SceneKit* kit : {&still, &moving}) {
    add_floor(*kit);
    kit->scene().lights.push_back(lamp({0, 2, 0}));
  }
  const EffectPlan alone = plan_of(still);
  EXPECT_FALSE(alone.on(Effect::kInterreflection));
  EXPECT_FALSE(alone.on(Effect::kShadows));
  add_moving(moving, {0, -3, 0}, {1, 1, 1});
  const EffectPlan plan = plan_of(moving);
  EXPECT_TRUE(plan.on(Effect::kInterreflection));
  EXPECT_TRUE(plan.on(Effect::kShadows));
}

TEST(EffectPlan, TheSkyOutsideAClosedRoomIsForThoseWhoMoveThere) {
  SceneKit inside, outside;
  for (SceneKit* kit : {&inside, &outside}) kit->box({0, 0, 0}, {4, 3, 4}, kit->material(Rgb{}));
  add_moving(inside, {1, 1, 1}, {2, 2, 2});
  EXPECT_FALSE(plan_of(inside, kSky).on(Effect::kSky));
  add_moving(outside, {11, 1, 1}, {12, 2, 2});
  EXPECT_TRUE(plan_of(outside, kSky).on(Effect::kSky));
}

// Probes by area alone would miss the balcony, by triangle the ground.
TEST(EffectPlan, TheSkyIsSeenByLargePartsAndBySmallOnesBesideDenseAndVastInteriors) {
  const auto dense = [](SceneKit& kit, float size) {
    const std::uint32_t grey = kit.material(Rgb::grey(0.5f));
    constexpr int kCells = 150;
    const float step = size / kCells;
    kit.box({0, 0, 0}, {size, size, size}, grey);
    for (int i = 0; i < kCells * kCells; ++i) {
      const float x = step * static_cast<float>(i % kCells),
                  z = step * static_cast<float>(i / kCells);
      kit.quad(
          {Vec3f{x, 0.5f, z}, {x, 0.5f, z + step}, {x + step, 0.5f, z + step}, {x + step, 0.5f, z}},
          grey);
    }
  };
  SceneKit ground, balcony;
  dense(ground, 1);
  ground.quad({Vec3f{-20, -1, 20}, {20, -1, 20}, {20, -1, -20}, {-20, -1, -20}},
              ground.material(Rgb::grey(0.5f)));
  EXPECT_TRUE(plan_of(ground, kSky).on(Effect::kSky));
  dense(balcony, 1000);
  balcony.quad({Vec3f{-2, 2, 2}, {-1, 2, 2}, {-1, 2, 1}, {-2, 2, 1}},
               balcony.material(Rgb::grey(0.5f)));
  EXPECT_TRUE(plan_of(balcony, kSky).on(Effect::kSky));
}

TEST(EffectPlan, TheSkyIsSeenByBacksOfTwoSidedSurfaces) {
  const auto wrapped = [](bool two_sided) {
    SceneKit kit;
    kit.box({0, 0, 0}, {4, 3, 4}, kit.material(Rgb::grey(0.5f), {}, two_sided));
    return plan_of(kit, kSky).on(Effect::kSky);
  };
  EXPECT_TRUE(wrapped(true));
  EXPECT_FALSE(wrapped(false));
}

TEST(EffectPlan, ACallerMaySwitchOnAnySkyThereIs) {
  SceneKit kit;
  kit.box({0, 0, 0}, {4, 3, 4}, kit.material(Rgb::grey(0.5f)));
  const EffectPlan plan = plan_of(kit, kSky, {"+sky"});
  EXPECT_TRUE(plan.on(Effect::kSky));
  EXPECT_TRUE(plan.on(Effect::kInterreflection));
  auto none = make_plan(kit.scene(), kit.optics(), kit.caster(), {}, 0.02, {"+sky"});
  EXPECT_EQ(none.status().reason(), "BAD_OPTION");
}

TEST(EffectPlan, ALampThatReachesOnlyWhatMovesIsOn) {
  SceneKit still, moving;
  for (SceneKit* kit : {&still, &moving}) {
    add_floor(*kit);
    kit->scene().lights.push_back(lamp({50, 2, 0}, 3));
  }
  EXPECT_FALSE(plan_of(still).on(Effect::kPointLights));
  add_moving(moving, {49, 0, 0}, {50, 1, 1});
  EXPECT_TRUE(plan_of(moving).on(Effect::kPointLights));
}

TEST(EffectPlan, DirectionalMapsNeedALitMaterialWithANormalMap) {
  scene::Material mapped;
  mapped.name = "brick";
  mapped.has_normal_map = true;
  scene::Material unlit = mapped;
  unlit.unlit = true;
  const std::array<Vec3f, 4> wall{Vec3f{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  SceneKit lit, bare;
  lit.quad(wall, lit.material(mapped));
  const EffectPlan plan = plan_of(lit, kSky);
  EXPECT_TRUE(plan.on(Effect::kDirectionalLightmaps));
  EXPECT_EQ(plan[Effect::kDirectionalLightmaps].evidence,
            std::vector<std::string>{"material brick"});
  EXPECT_FALSE(plan_of(lit).on(Effect::kDirectionalLightmaps));  // dark
  EXPECT_FALSE(plan_of(lit, kSky, {"-directional_lightmaps"}).on(Effect::kDirectionalLightmaps));
  bare.quad(wall, bare.material(unlit));
  EXPECT_FALSE(plan_of(bare, kSky).on(Effect::kDirectionalLightmaps));
}

}  // namespace
}  // namespace lightbatch::plan
