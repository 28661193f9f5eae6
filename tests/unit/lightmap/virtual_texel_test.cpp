#include "core/lightmap/virtual_texel.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/accuracy/path_tracer.h"
#include "tests/unit/lightmap/lit_scene.h"

namespace lightbatch::lightmap {
namespace {

/// A closed room of 4 x 3 x 4 m, a board in it, and a narrow spot light that makes one bright patch
/// on the floor: next to all light comes from there.
struct PatchOfLight {
  LitScene lit;
  explicit PatchOfLight(double cone = 0.15, const Rgb& walls = {0.7f, 0.6f, 0.5f}) {
    auto& kit = lit.kit;
    kit.box({0, 0, 0}, {4, 3, 4}, kit.material(walls));
    kit.box({2.2f, 0.8f, 1}, {3.4f, 0.9f, 2.6f}, kit.material(Rgb::grey(0.5f)), false);
    scene::Light light;
    light.kind = scene::LightKind::kSpot;
    light.position = {1, 2.9, 1};
    light.direction = {0, -1, 0};
    light.intensity = Rgb::grey(1000);
    light.cos_inner = light.cos_outer = std::cos(cone);
    kit.scene().lights.push_back(light);
    lit.rays = 1024;
    lit.chart(4);
    lit.solve();
  }
  radiosity::VirtualLights lights(const radiosity::VirtualLightOptions& options) const {
    const BakeInput input = lit.input();
    return {input.scene, input.elements, input.direct, input.solution, options};
  }
};

TEST(VirtualLights, SendOnWhatThePatchReceives) {
  const PatchOfLight room;
  const auto lights = room.lights({2000, 0, 1});
  ASSERT_FALSE(lights.is_empty());
  // Tries on elements that are lit in part may find the light more often than expected.
  EXPECT_GE(lights.count(), 1500u);
  EXPECT_LE(lights.count(), 4000u);
  Rgbd flux;
  for (std::size_t i = 0; i < lights.count(); ++i) flux += to_double(lights[i].flux);
  // A cone of 0.15 rad: solid angle 2 pi (1 - cos) of 1000 cd, reflected by 0.7, 0.6, 0.5.
  const double sent = 2 * kPiDouble * (1 - std::cos(0.15)) * 1000;
  EXPECT_NEAR(flux.r, 0.7 * sent, 0.03 * sent);
  EXPECT_NEAR(flux.b, 0.5 * sent, 0.03 * sent);
}

TEST(VirtualLights, NoneWhereNothingStandsOut) {
  // White walls, half of them in the light: what cosine rays meet is as good.
  const PatchOfLight bright(1.0, Rgb::grey(0.95f));
  EXPECT_TRUE(bright.lights({2000, 0, 1}).is_empty());
  const PatchOfLight room;
  EXPECT_TRUE(room.lights({0, 0, 1}).is_empty());
}

TEST(VirtualLights, FarReceiversAreServedAsIfByOnePoint) {
  const PatchOfLight room;
  const auto lights = room.lights({500, 0, 1});
  radiosity::VirtualLights::ReceiverPatch at{{1, 3, 1}, {0, -1, 0}};
  radiosity::VirtualLights::Served served;
  lights.serve(at, served);
  double flux = 0, picked = 0;
  for (std::size_t i = 0; i < lights.count(); ++i) {
    flux += static_cast<double>(lights[i].flux.sum());
  }
  // Straight above by 3 m: flux / (pi r^2); the patch is 0.44 m in radius, which takes off
  // r^2 / (r^2 + 0.44^2) in the mean, by the disc's form factor.
  EXPECT_NEAR(served.sum, flux / (kPiDouble * (9 + 0.44 * 0.44)), 0.02 * served.sum);
  // Every part of the sum belongs to a light that is served.
  for (int k = 0; k < 1000; ++k) {
    const std::size_t i = served.find((k + 0.5) / 1000 * served.sum);
    ASSERT_LT(i, lights.count());
    ASSERT_GT(served.by_light[i], 0.0f);
    picked += static_cast<double>(lights[i].position.x) / 1000;
  }
  EXPECT_NEAR(picked, 1, 0.02);
  at.position = {1, 0.05f, 1};
  lights.serve(at, served);
  // 500 points on a disc of 0.44 m: 3.5 cm apart. What is nearer than three times that has to be
  // met.
  for (std::size_t i = 0; i < lights.count(); ++i) {
    const Vec3f to = lights[i].position - at.position;
    if (dot(to, to) < 0.09f * 0.09f) {
      EXPECT_EQ(served.by_light[i], 0.0f) << i;
    }
  }
}

// A crumpled texel: picked by what it brings to one point, a light may bring another hundreds of
// times as much.
TEST(VirtualLights, BringAboutAsMuchToAllPointsOfAReceiverPatch) {
  const PatchOfLight room;
  const auto lights = room.lights({500, 0, 1});
  radiosity::VirtualLights::ReceiverPatch at{{2, 0.3f, 1}, {0, -1, 0}};
  at.extent = 0.4f;
  at.tilt = 0.3f;
  radiosity::VirtualLights::Served served;
  lights.serve(at, served);
  const auto brings = [&](std::size_t i, const Vec3f& position, const Vec3f& normal) {
    const Vec3f to = lights[i].position - position;
    const float squared = dot(to, to);
    return std::max(0.0f, dot(to, normal)) * std::max(0.0f, -dot(to, lights[i].normal)) /
           (squared * squared);
  };
  std::size_t asked = 0;
  for (std::size_t i = 0; i < lights.count(); ++i) {
    if (!(served.by_light[i] > 0)) continue;
    ++asked;
    for (const Vec3f& off : {Vec3f{-0.4f, 0, 0}, {0, -0.2f, 0}, {0, 0, 0.4f}}) {
      const float tilted = brings(i, at.position + off, normalized(Vec3f{-0.3f, -1, 0}));
      EXPECT_LT(tilted, 20 * brings(i, at.position, at.normal)) << i;
    }
  }
  EXPECT_GT(asked, 0u);
  EXPECT_LT(asked, lights.count());
}

// What rays leave out and what virtual lights bring are the same, wherever the receiver is.
TEST(VirtualLights, ServeWhatRaysLeaveOut) {
  const PatchOfLight room;
  const auto lights = room.lights({500, 0, 1});
  const BakeInput input = room.lit.input();
  std::size_t served = 0, not_served = 0;
  for (const Vec3f position : {Vec3f{1, 3, 1}, {1.2f, 0.1f, 1}, {0, 0.05f, 1}, {1, -0.1f, 1}}) {
    for (const Vec3f normal : {Vec3f{0, -1, 0}, {1, 0, 0}, {0, 1, 0}}) {
      radiosity::VirtualLights::ReceiverPatch at{position, normal};
      at.tilt = normal.y < 0 ? 0.5f : 0.0f;
      radiosity::VirtualLights::Served by;
      lights.serve(at, by);
      for (std::size_t i = 0; i < lights.count(); ++i) {
        optics::SurfaceFrame there;
        there.position = lights[i].position;
        there.normal = lights[i].normal;
        rays::Ray down{there.position + there.normal * 0.01f, -there.normal};
        const rays::Hit hit = input.caster.closest(down);
        const auto e = input.elements.at(hit.triangle, hit.u, hit.v, hit.back);
        const bool serves = lights.serves(e, at, there);
        EXPECT_EQ(serves, by.by_light[i] > 0) << i;
        ++(serves ? served : not_served);
      }
    }
  }
  EXPECT_GT(served, 100u);
  EXPECT_GT(not_served, 100u);
}

TEST(VirtualTexel, SameLightAndLessNoise) {
  const PatchOfLight room;
  GatherSettings settings;
  settings.rays = 64;
  settings.block = 1;
  radiosity::GroupedLight none;
  const accuracy::PathTracer tracer(room.lit.kit.caster(), room.lit.kit.optics(), room.lit.sky);
  const auto bake = [&](int lights) {
    settings.virtual_lights = lights;
    BakeCounts counts;
    const DimShares dim(room.lit.input(), settings);
    return bake_indirect(room.lit.input(), settings, dim, none, counts, Progress{});
  };
  const auto plain = bake(0), virtual_too = bake(2048);
  double truth = 0, mean = 0, squares = 0, plain_squares = 0;
  for (std::uint32_t t = 0; t < plain.size(); t += 7) {
    const auto& texel = room.lit.texels.texels[t];
    const TexelPoints grid = texel_points(room.lit.texels, texel);
    // Where the spot light itself falls, noise of direct light would hide the rest.
    const auto at = receiver_at(room.lit.kit.scene(), room.lit.layout, grid.point[0], 0);
    if (at.frame.position.y < 0.01f) continue;
    const double want = tracer.irradiance(room.lit.points_of(t), 8192, t).irradiance.g;
    truth += want;
    mean += static_cast<double>(virtual_too[t].g);
    squares += std::pow(static_cast<double>(virtual_too[t].g) - want, 2);
    plain_squares += std::pow(static_cast<double>(plain[t].g) - want, 2);
  }
  EXPECT_GT(truth, 0);
  EXPECT_NEAR(mean / truth, 1, 0.015);
  EXPECT_LT(squares, 0.3 * plain_squares);
}

}  // namespace
}  // namespace lightbatch::lightmap
